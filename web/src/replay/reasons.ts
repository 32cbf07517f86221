/** Why the robot stood or was slow, and why a turn ended: short names on the tape, here in words. */

import { isCode, said } from "../words/said";
import { type Code, t } from "../words/words";

/** What is the server's to say, in the order in which a name is looked for. */
const AREAS = ["drive", "hold", "limit"];
/** Reasons that nobody is told in the server's words. */
const OWN: Readonly<Record<string, Code>> = {
  nobody_drives: "replay.why.nobody",
  pressed: "replay.why.pressed",
  robot: "replay.why.robot",
};

const ENDS: Readonly<Record<string, Code>> = {
  expired: "replay.turn.expired",
  left: "replay.turn.left",
  gone: "replay.turn.gone",
  idle: "replay.turn.idle",
  "ended by the host": "replay.turn.ended",
};

/** What the operator was told, or the name as it is where a newer server has written it. */
export function reasonWords(name: string): string {
  const own = OWN[name];
  if (own) return t(own);
  const code = AREAS.map((area) => `${area}.${name}`).find(isCode);
  if (code === undefined) return name.replaceAll("_", " ");
  return t("replay.why.told", { sentence: said({ code, values: {} }) });
}

/** Why a turn ended. */
export function endWords(why: string | null): string {
  return t(ENDS[why ?? ""] ?? "replay.turn.unknown");
}
