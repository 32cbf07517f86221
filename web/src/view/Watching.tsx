import { t } from "../words/words";
import { useState } from "./context";
import { Fullscreen } from "./Fullscreen";
import { OutputChoice } from "./OutputChoice";
import { PictureInPicture } from "./PictureInPicture";
import { silenceWords } from "./pageWords";
import { Snapshot } from "./Snapshot";
import { Timing } from "./Timing";
import { Volume } from "./Volume";

/** The tools for watching and listening, for everybody. */
export function Watching() {
  const { hello } = useState();
  const hasSound = silenceWords(hello.value) === null;
  return (
    <section class="watching" aria-label={t("watch.title")}>
      {hasSound && <Volume />}
      {hasSound && <OutputChoice />}
      <Timing />
      <div class="watch-acts">
        <Snapshot />
        <PictureInPicture />
        <Fullscreen />
      </div>
    </section>
  );
}
