import { useSignal } from "@preact/signals";
import { useLayoutEffect } from "preact/hooks";
import { AXIS_USES, controlUse, type Learnt } from "../../drive/learntParts";
import type { Found } from "../../drive/padLearner";
import { type PadLayout, type PadPart, PRINTED } from "../../drive/padReading";
import { type Code, t } from "../../words/words";
import { useActions, useState } from "../context";
import { directionNames } from "../directionNames";
import { partName } from "./padNames";

interface Use {
  use: string;
  name: string;
  /** Its usual button's label; "" for none. */
  usual: string;
}

const AXIS_NAMES: Record<(typeof AXIS_USES)[number], Code> = {
  ahead: "ways.pad_ahead",
  turn: "ways.pad_turns",
  sideways: "ways.pad_slides",
};
const CROSS = ["forward", "back", "left", "right"] as const;
const isAxisUse = (use: string) => AXIS_USES.some((one) => one === use);

/** Which part of the gamepad in use does what; a part is chosen by pressing or pushing it. */
export function PadParts({ id, layout }: { id: string; layout: PadLayout }) {
  const { preferences } = useState();
  const { learnPad, setDriving } = useActions();
  const awaited = useSignal<Use | null>(null);
  const complaint = useSignal("");
  const uses = useUses();
  const learnt = preferences.value.gamepad.learnt[id] ?? {};

  const isFree = (usual: string) =>
    usual !== "" &&
    !Object.values(learnt).some(({ kind, at }) => kind === "button" && PRINTED[at] === usual);

  const keep = (parts: Learnt, rests = preferences.peek().gamepad.rests) => {
    const { gamepad } = preferences.peek();
    setDriving({ gamepad: { ...gamepad, rests, learnt: { ...gamepad.learnt, [id]: parts } } });
  };

  const choose = ({ use }: Use, { from, ...part }: Found) => {
    awaited.value = null;
    const { rests, learnt: all, deadZone } = preferences.peek().gamepad;
    const parts = all[id] ?? {};
    const by = uses.find((one) => one.use !== use && isSame(parts[one.use], part));
    if (by) {
      const values = { part: partName(part, layout), action: by.name };
      complaint.value = t("ways.pad_taken", values);
      return;
    }
    // A throttle rests where it began; any other axis in its middle.
    const rest = Math.abs(from) > deadZone ? Math.max(-1, Math.min(1, from)) : 0;
    const own = Array.from({ length: Math.max(3, part.at + 1, rests[id]?.length ?? 0) }, (_, at) =>
      at === part.at ? rest : (rests[id]?.[at] ?? 0),
    );
    keep({ ...parts, [use]: part }, isAxisUse(use) ? { ...rests, [id]: own } : rests);
  };

  const wanted = awaited.value;
  useLayoutEffect(() => {
    if (!wanted) return;
    learnPad({ isAxis: isAxisUse(wanted.use), found: (part) => choose(wanted, part) });
    return () => learnPad(null);
  }, [wanted]);

  return (
    <fieldset class="ways-group">
      <legend>{t("ways.pad_parts")}</legend>
      <ul class="ways-keys">
        {uses.map((one) => {
          const part = learnt[one.use];
          const { [one.use]: _, ...others } = learnt;
          return (
            <li key={one.use}>
              <span>
                <bdi>{one.name}</bdi>
              </span>
              {part ? (
                <button
                  type="button"
                  class="key-cap"
                  aria-label={t("ways.keys_remove", {
                    key: partName(part, layout),
                    action: one.name,
                  })}
                  onClick={() => keep(others)}
                >
                  <kbd>{partName(part, layout)}</kbd> <span aria-hidden="true">×</span>
                </button>
              ) : (
                layout === "standard" && isFree(one.usual) && <kbd>{one.usual}</kbd>
              )}
              <button
                type="button"
                class="key-cap"
                aria-label={t("ways.pad_learn", { action: one.name })}
                aria-pressed={wanted?.use === one.use}
                onClick={() => {
                  complaint.value = "";
                  awaited.value = wanted?.use === one.use ? null : one;
                }}
              >
                +
              </button>
            </li>
          );
        })}
      </ul>
      <p class="ways-told" aria-live="polite">
        {wanted
          ? t(isAxisUse(wanted.use) ? "ways.pad_push" : "ways.pad_press", { action: wanted.name })
          : complaint.value}
      </p>
    </fieldset>
  );
}

const isSame = (one: (PadPart & { to: number }) | undefined, part: PadPart & { to: number }) =>
  one?.kind === part.kind && one.at === part.at && (part.kind === "button" || one.to === part.to);

/** What a gamepad can do with this robot. */
function useUses(): Use[] {
  const { hello, movesSideways } = useState();
  const isPlanar = movesSideways.value;
  const names = directionNames(isPlanar);
  const controls = hello.value?.controls ?? [];
  return [
    ...AXIS_USES.filter((use) => use !== "sideways" || isPlanar).map((use) => ({
      use,
      name: t(AXIS_NAMES[use]),
      usual: "",
    })),
    ...CROSS.map((use) => ({ use, name: t(names[use]), usual: "" })),
    { use: "stop", name: t("stop.stop"), usual: PRINTED[1] ?? "" },
    { use: "speed", name: t("ways.do_speed"), usual: PRINTED[0] ?? "" },
    ...controls
      .filter(({ kind }) => kind === "button" || kind === "toggle")
      .map(({ name, label, pad_button: usual }) => ({ use: controlUse(name), name: label, usual })),
  ];
}
