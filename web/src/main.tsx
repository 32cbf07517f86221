/** Starts the session and draws the page or another view, or says why this browser cannot. */

import "./style/base.css";
import "./style/layout.css";
import "./style/hud.css";
import "./style/tape.css";
import "./style/picture.css";
import "./style/views.css";
import "./style/turn.css";
import "./style/drive.css";
import "./style/joystick.css";
import "./style/axes.css";
import "./style/gauges.css";
import "./style/voice.css";
import "./style/queue.css";
import "./style/settings.css";
import "./style/panels.css";
import "./style/watching.css";
import "./style/stop.css";
import "./style/notices.css";
import "./style/call.css";
import "./style/ended.css";
import "./style/branding.css";
import "./style/loading.css";
import { render } from "preact";
import { openView, viewOf } from "./openView";
import { startSession } from "./session";
import { type Lacks, lacksOf } from "./support";
import { App } from "./view/App";
import { languageWishes, pickLanguage, switchLanguage } from "./words/language";
import { loadLaterEnglish } from "./words/words";

/** The page is drawn after this long even if no server has answered. */
const DRAWN_WITHIN_MS = 150;

const lacks = lacksOf();
const root = document.getElementById("page");
if (root && lacks) {
  void refuse(root, lacks);
} else if (root) {
  const session = startSession();
  // Drawing first would delay the offer; afterwards there is time while the server answers.
  const atLast = new Promise((resolve) => setTimeout(resolve, DRAWN_WITHIN_MS));
  void Promise.race([session.offered, atLast]).then(() => {
    // Remove the text that says the page is loading.
    root.replaceChildren();
    const view = viewOf(window.location.search);
    if (view) void openView(root, session, view);
    else render(<App session={session} />, root);
  });
}

/** Says why this browser cannot show the page; loaded on demand, since few need it. */
async function refuse(root: HTMLElement, lacks: Lacks): Promise<void> {
  void switchLanguage(pickLanguage(languageWishes(null)));
  const [{ UnsupportedPage }] = await Promise.all([
    import("./view/UnsupportedPage"),
    loadLaterEnglish(),
  ]);
  root.replaceChildren();
  render(<UnsupportedPage lacks={lacks} />, root);
}
