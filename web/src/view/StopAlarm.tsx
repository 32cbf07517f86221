import { t } from "../words/words";
import { useState } from "./context";

/** That nobody has confirmed a Stop that was pressed here, for as long as that is so. */
export function StopAlarm() {
  if (!useState().isStopUnconfirmed.value) return null;
  return (
    <p class="toast stop-alarm" role="alert">
      {t("stop.unconfirmed")}
    </p>
  );
}
