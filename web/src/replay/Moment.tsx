import type { Signal } from "@preact/signals";
import { t } from "../words/words";
import type { View } from "./player";
import { commandWords, reportedWords, steeredWords, watchedWords } from "./replayWords";
import type { OpenPart } from "./timeline";

interface MomentProps {
  open: OpenPart;
  momentMs: Signal<number>;
  view: Signal<View>;
}

/** The state at this moment, in words. */
export function Moment({ open, momentMs, view }: MomentProps) {
  const { timeline } = open;
  const atMs = momentMs.value;
  const command = view.value === "was" ? timeline.commandAt(atMs) : timeline.sentAt(atMs);
  return (
    <dl class="replay-moment">
      <dt>{t("replay.drives")}</dt>
      <dd>{timeline.who(timeline.operatorAt(atMs))}</dd>
      <dt>{t(view.value === "was" ? "replay.counts" : "replay.hands")}</dt>
      <dd>{commandWords(command)}</dd>
      <dt>{t("replay.told")}</dt>
      <dd>{steeredWords(timeline.steeredAt(atMs))}</dd>
      <dt>{t("replay.reports")}</dt>
      <dd>{reportedWords(timeline.reportedAt(atMs))}</dd>
      <dt>{t("replay.watched")}</dt>
      <dd>{watchedWords(timeline.watchedAt(atMs))}</dd>
    </dl>
  );
}
