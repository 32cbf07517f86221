import "./style/base.css";
import "./style/layout.css";
import "./style/parts.css";
import { render } from "preact";
import { startSession } from "./session";
import { App } from "./view/App";

const root = document.getElementById("page");
// The offer is on its way before anything is drawn.
const session = startSession();
if (root) render(<App session={session} />, root);
