import "../style/base.css";
import "./replay.css";
import { render } from "preact";
import { choose, speak, wishes } from "../words/language";
import { loadSaid } from "../words/said";
import { t } from "../words/words";
import { Replay } from "./Replay";

const root = document.getElementById("page");

// Nobody chooses a language here, so it is there before the page; without it, it is English.
Promise.allSettled([speak(choose(wishes(null))), loadSaid()]).then(() => {
  document.title = `WAX: ${t("replay.title")}`;
  if (root) render(<Replay />, root);
});
