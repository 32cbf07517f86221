import { t } from "../words/words";
import { useState } from "./context";

/** Warns while a Stop that was pressed here is not confirmed. */
export function StopAlarm() {
  if (!useState().isStopUnconfirmed.value) return null;
  return (
    <p class="toast stop-alarm" role="alert">
      {t("stop.unconfirmed")}
    </p>
  );
}
