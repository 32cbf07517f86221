import "../style/base.css";
import "./replay.css";
import { render } from "preact";
import replay from "../words/en/replay.json";
import { languageWishes, pickLanguage, switchLanguage } from "../words/language";
import { loadSaid } from "../words/said";
import { addEnglish, loadLaterEnglish, t } from "../words/words";
import { Replay } from "./Replay";

const root = document.getElementById("page");

addEnglish(replay);
// There is no choice of language here, so it is loaded before drawing; if that fails, English.
Promise.allSettled([
  switchLanguage(pickLanguage(languageWishes(null))),
  loadLaterEnglish(),
  loadSaid(),
]).then(() => {
  document.title = `WAX: ${t("replay.title")}`;
  if (root) render(<Replay />, root);
});
