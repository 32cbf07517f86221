import "../style/base.css";
import "./replay.css";
import { render } from "preact";
import { Replay } from "./Replay";

const root = document.getElementById("page");
if (root) render(<Replay />, root);
