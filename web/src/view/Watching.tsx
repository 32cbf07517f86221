import { t } from "../words/words";
import { useState } from "./context";
import { late } from "./late";
import { OutputChoice } from "./OutputChoice";
import { silenceWords } from "./pageWords";
import { Timing } from "./Timing";
import { Volume } from "./Volume";

export const WatchActs = late(async () => (await import("./WatchActs")).WatchActs);

/** The tools for watching and listening, for everybody. */
export function Watching() {
  const { hello } = useState();
  const hasSound = silenceWords(hello.value) === null;
  return (
    <section class="watching" aria-label={t("watch.title")}>
      {hasSound && <Volume />}
      {hasSound && <OutputChoice />}
      <Timing />
      <WatchActs />
    </section>
  );
}
