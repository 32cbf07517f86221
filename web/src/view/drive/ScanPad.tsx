import { type ScanItem, scanItems } from "../../drive/scanner";
import { type Code, t } from "../../words/words";
import { useActions, useState } from "../context";
import { directionNames } from "../directionNames";

/** What is offered to a switch, with the same switches as buttons on the screen. */
export function ScanPad() {
  const { scan: offered, preferences, movesSideways } = useState();
  const { scan } = useActions();
  if (offered.value === null) return null;
  const items = scanItems(offered.value === "release", movesSideways.value);
  const names: Record<ScanItem, Code> = {
    ...directionNames(movesSideways.value),
    stop: "stop.stop",
    release: "ways.scan_release",
  };
  return (
    <fieldset class="scan" aria-label={t("ways.scan")}>
      <ol class="scan-items">
        {items.map((item) => (
          <li
            key={item}
            class={`scan-item is-${item}`}
            aria-current={item === offered.value ? "true" : undefined}
          >
            {t(names[item])}
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
