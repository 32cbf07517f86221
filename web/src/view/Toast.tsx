import { useEffect } from "preact/hooks";
import { said } from "../words/said";
import { useState } from "./context";

const SHOWN_MS = 6000;

/** The newest notice, for a few seconds. */
export function Toast() {
  const { notice } = useState();
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
      {shown && <p class="toast">{said(shown.text)}</p>}
    </div>
  );
}
