import { useEffect } from "preact/hooks";
import { said } from "../words/said";
import { t } from "../words/words";
import { useState } from "./context";

const SHOWN_MS = 6000;

/** The newest notice, for a few seconds; a Stop that nobody has confirmed, for as long as that is so. */
export function Toast() {
  const { notice, isStopUnconfirmed } = useState();
  const shown = notice.value;
  useEffect(() => {
    if (!shown) return;
    const timer = setTimeout(() => {
      notice.value = null;
    }, SHOWN_MS);
    return () => clearTimeout(timer);
  }, [shown, notice]);
  return (
    <div class="toasts" aria-live="polite">
      {isStopUnconfirmed.value && (
        <p class="toast is-alarm" role="alert">
          {t("stop.unconfirmed")}
        </p>
      )}
      {shown && <p class="toast">{said(shown.text)}</p>}
    </div>
  );
}
