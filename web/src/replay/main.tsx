import "../style/base.css";
import "./replay.css";
import { render } from "preact";
import replay from "../words/en/replay.json";
import { choose, speak, wishes } from "../words/language";
import { loadSaid } from "../words/said";
import { learn, learnLater, t } from "../words/words";
import { Replay } from "./Replay";

const root = document.getElementById("page");

learn(replay);
// Nobody chooses a language here, so it is there before the page; without it, it is English.
Promise.allSettled([speak(choose(wishes(null))), learnLater(), loadSaid()]).then(() => {
  document.title = `WAX: ${t("replay.title")}`;
  if (root) render(<Replay />, root);
});
