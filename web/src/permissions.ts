/**
 * What this page's user may do now, so that the page offers nothing the server would refuse. The
 * server decides (`access/permissions.py`, `control/stop_latch.py`); this only follows it.
 */

import { computed, type ReadonlySignal } from "@preact/signals";
import type { ControlInfo, Hello, RoomState, ViewerInfo } from "./messages";

export interface Permissions {
  /** Whether this page drives and no stop is in force. */
  mayMove: ReadonlySignal<boolean>;
  /** The robot's controls that this page may use now; one that moves also needs `mayMove`. */
  usableControls: ReadonlySignal<readonly ControlInfo[]>;
  /** Whether this page may speak through the robot: the operator's and the host's may. */
  maySpeak: ReadonlySignal<boolean>;
  /** Every viewer may, even offline, unless the server allows only operator and host. */
  mayStop: ReadonlySignal<boolean>;
  /** The host may; the operator too, unless the host pressed Stop. */
  mayRelease: ReadonlySignal<boolean>;
  mayKeepTape: ReadonlySignal<boolean>;
  isHost: ReadonlySignal<boolean>;
}

/** What permissions depend on; `isHere`: connected to the robot's server, not to a LiveKit room. */
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
      // A person aboard may not have handed the robot over to its operator.
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
