/** The host's branding, available even before the server's hello. */

import type { PageInfo } from "../messages";
import type { State } from "../state";
import { t } from "../words/words";

/** The host's texts; where they wrote no sentence, one of ours. */
export function brandedPage(state: State): Pick<PageInfo, "sentence" | "rules" | "links"> {
  const { sentence = "" } = document.documentElement.dataset;
  const page = state.hello.value?.page ?? { sentence, rules: [], links: [] };
  return { ...page, sentence: page.sentence || t("branding.sentence") };
}

/** What a newcomer can do here, in three sentences: what this is, how to drive, how to stop it. */
export function welcomeWords(state: State): string[] {
  const hello = state.hello.value;
  const { sentence } = brandedPage(state);
  if (!hello) return [sentence];
  const stop =
    hello.on_loss.stop_by === "everybody" ? "welcome.everybody_stops" : "welcome.operator_stops";
  return [
    sentence,
    hello.may_queue ? drivingWords(hello.turn_s) : t("welcome.only_watch"),
    t(stop),
  ];
}

/** How to drive, without the length of a turn that lasts for hours. */
function drivingWords(turnS: number): string {
  if (turnS > 3600) return t("welcome.how_to_drive_free");
  const isWhole = turnS >= 120 && turnS % 60 === 0;
  const time = isWhole
    ? t("welcome.minutes", { n: turnS / 60 })
    : t("welcome.seconds", { n: Math.round(turnS) });
  return t("welcome.how_to_drive", { time });
}
