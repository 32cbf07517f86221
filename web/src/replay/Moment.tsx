import type { Signal } from "@preact/signals";
import type { View } from "./player";
import type { Open } from "./Replay";
import { commandWords, reportedWords, steeredWords, watchedWords } from "./words";

interface MomentProps {
  open: Open;
  momentMs: Signal<number>;
  view: Signal<View>;
}

/** What was so at this moment, in words. */
export function Moment({ open, momentMs, view }: MomentProps) {
  const { timeline } = open;
  const atMs = momentMs.value;
  const command = view.value === "was" ? timeline.commandAt(atMs) : timeline.sentAt(atMs);
  return (
    <dl class="replay-moment">
      <dt>Drives</dt>
      <dd>{timeline.who(timeline.operatorAt(atMs))}</dd>
      <dt>{view.value === "was" ? "Command that counts" : "Their hands"}</dt>
      <dd>{commandWords(command)}</dd>
      <dt>Robot is told</dt>
      <dd>{steeredWords(timeline.steeredAt(atMs))}</dd>
      <dt>Robot says</dt>
      <dd>{reportedWords(timeline.reportedAt(atMs))}</dd>
      <dt>Operator has it</dt>
      <dd>{watchedWords(timeline.watchedAt(atMs))}</dd>
    </dl>
  );
}
