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
import "./style/host.css";
import "./style/stop.css";
import "./style/notices.css";
import "./style/call.css";
import "./style/ended.css";
import "./style/own.css";
import "./style/path.css";
import { render } from "preact";
import { startSession } from "./session";
import { App } from "./view/App";

const root = document.getElementById("page");
// The offer is on its way before anything is drawn.
const session = startSession();
if (root) render(<App session={session} />, root);
