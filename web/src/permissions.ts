/**
 * What this page's user may do now, so that the page offers nothing that the server refuses. The
 * server decides (`access/permissions.py`, `control/stop_latch.py`); this only follows it.
 */

import { computed, type ReadonlySignal } from "@preact/signals";
import type { ControlInfo, Hello, RoomState, ViewerInfo } from "./messages";

export interface Permissions {
  /** Whether this page drives and no stop is in force. */
  mayMove: ReadonlySignal<boolean>;
  /** Those of the robot's controls that this page may use now; what moves also needs `mayMove`. */
  usableControls: ReadonlySignal<readonly ControlInfo[]>;
  /** Whether this page may speak through the robot: while it drives, and the host's. */
  maySpeak: ReadonlySignal<boolean>;
  /** Every viewer, unless the server allows only operator and host; even without a connection. */
  mayStop: ReadonlySignal<boolean>;
  /** The host, and the operator where the host has not pressed it. */
  mayRelease: ReadonlySignal<boolean>;
  mayKeepTape: ReadonlySignal<boolean>;
  isHost: ReadonlySignal<boolean>;
}

/** What they follow from; `isHere`: connected to the robot's server, not watching in a room. */
interface Known {
  hello: ReadonlySignal<Hello | null>;
  room: ReadonlySignal<RoomState | null>;
  me: ReadonlySignal<ViewerInfo | null>;
  drivingTurn: ReadonlySignal<number | null>;
  isHere: ReadonlySignal<boolean>;
}

export function permissions({ hello, room, me, drivingTurn, isHere }: Known): Permissions {
  const isHost = computed(() => hello.value?.is_host === true);
  const isOperator = computed(() => me.value?.role === "operator");
  const isInCharge = computed(() => isOperator.value || isHost.value);
  const isDriving = computed(() => drivingTurn.value !== null);

  return {
    mayMove: computed(() => isDriving.value && room.value?.stop == null),
    usableControls: computed(() => {
      if (!isHere.value) return [];
      // Who sits in the robot, if somebody does, may not have left it to its operator.
      const isLeft = (room.value?.aboard?.mode ?? "free") === "free";
      const roles = { operator: isDriving.value && isLeft, host: isHost.value, observer: true };
      const controls = hello.value?.controls ?? [];
      return controls.filter((one) => one.roles.some((role) => roles[role]));
    }),
    maySpeak: computed(() => {
      const isTaken = hello.value?.voice != null && isHere.value;
      return isTaken && (isDriving.value || isHost.value);
    }),
    mayStop: computed(() => hello.value?.on_loss.stop_by !== "operator" || isInCharge.value),
    mayRelease: computed(
      () => isHost.value || (isOperator.value && room.value?.stop?.by_host !== true),
    ),
    mayKeepTape: isInCharge,
    isHost,
  };
}
