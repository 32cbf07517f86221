/** Words for the tape's codes of why the robot stood or was slow, and why a turn ended. */

import { isCode, said } from "../words/said";
import { type Code, t } from "../words/words";

/** Areas of the server's sentences, in the order in which a name is looked up. */
const AREAS = ["drive", "hold", "limit"];
/** Reasons that the server has no sentence for. */
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

/** What the operator was told; for an unknown name, written by a newer server, the name itself. */
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
