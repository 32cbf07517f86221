import { type PadLayout, type PadPart, PRINTED } from "../../drive/padReading";
import { t } from "../../words/words";

/** The label on the gamepad; numbers count from 1, as on sticks and in system settings. */
export function partName({ kind, at }: PadPart, layout: PadLayout): string {
  const n = String(at + 1);
  if (layout !== "standard" || (kind === "axis" && at > 3))
    return t(kind === "axis" ? "ways.pad_axis" : "ways.pad_button", { n });
  if (kind === "axis") return t(at < 2 ? "ways.pad_turn_left" : "ways.pad_turn_right");
  return PRINTED[at] ?? t("ways.pad_button", { n });
}
