import "./style/base.css";
import "./style/layout.css";
import "./style/hud.css";
import "./style/tape.css";
import "./style/stage.css";
import "./style/views.css";
import "./style/turn.css";
import "./style/drive.css";
import "./style/joystick.css";
import "./style/ways.css";
import "./style/voice.css";
import "./style/queue.css";
import "./style/settings.css";
import "./style/panels.css";
import "./style/watching.css";
import "./style/host.css";
import "./style/stop.css";
import "./style/notices.css";
import "./style/call.css";
import "./style/ended.css";
import "./style/own.css";
import "./style/path.css";
import "./style/loading.css";
import { render } from "preact";
import { openStage, wantsStage } from "./openStage";
import { startSession } from "./session";
import { lacksOf } from "./support";
import { App } from "./view/App";
import { UnsupportedPage } from "./view/UnsupportedPage";
import { choose, speak, wishes } from "./words/language";

const lacks = lacksOf();
// The offer is on its way before anything is drawn.
const session = lacks ? null : startSession();
const root = document.getElementById("page");
// Until now it says that the page is loading.
root?.replaceChildren();
if (root && session && wantsStage(window.location.search)) void openStage(root, session);
else if (root && session) render(<App session={session} />, root);
else if (root && lacks) {
  void speak(choose(wishes(null)));
  render(<UnsupportedPage lacks={lacks} />, root);
}
