import { type ScanItem, scanItems } from "../../drive/scanner";
import { type Code, t } from "../../words/words";
import { useActions, useState } from "../context";

const NAMES: Record<ScanItem, Code> = {
  forward: "drive.forward",
  back: "drive.back",
  left: "drive.left",
  right: "drive.right",
  lateral_left: "drive.lateral_left",
  lateral_right: "drive.lateral_right",
  stop: "stop.stop",
  release: "ways.scan_release",
};

/** What is offered to a switch, with the same switches as buttons on the screen. */
export function ScanPad() {
  const { scan: offered, preferences, movesSideways } = useState();
  const { scan } = useActions();
  if (offered.value === null) return null;
  const items = scanItems(offered.value === "release", movesSideways.value);
  return (
    <fieldset class="scan" aria-label={t("ways.scan")}>
      <ol class="scan-items">
        {items.map((item) => (
          <li
            key={item}
            class={`scan-item is-${item}`}
            aria-current={item === offered.value ? "true" : undefined}
          >
            {t(NAMES[item])}
          </li>
        ))}
      </ol>
      <button type="button" class="scan-button" onClick={() => scan("select")}>
        {t("ways.scan_select")}
      </button>
      {preferences.value.switches === 2 && (
        <button type="button" class="scan-button" onClick={() => scan("next")}>
          {t("ways.scan_next")}
        </button>
      )}
    </fieldset>
  );
}
