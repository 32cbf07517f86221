import "../../style/ways.css";
import { t } from "../../words/words";
import { KeyChoice } from "./KeyChoice";
import { PadChoice } from "./PadChoice";
import { WayChoice } from "./WayChoice";

/** How the user drives: the way, a gamepad, the keys. */
export function WaysPanel() {
  return (
    <section class="ways" aria-label={t("ways.title")}>
      <WayChoice />
      <PadChoice />
      <KeyChoice />
    </section>
  );
}
