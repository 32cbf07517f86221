import { said } from "../words/said";
import { t } from "../words/words";
import { AboardBanner } from "./AboardBanner";
import { useState } from "./context";
import { whenWords } from "./pageWords";

/** Above the picture: the person aboard, the host's message, a broken tunnel, a bad link. */
export function Banners() {
  const { room, messageEndsMs, entryProblem } = useState();
  const endsMs = messageEndsMs.value;
  const message = room.value?.host_settings.message;
  const noWayIn = room.value?.no_way_in;
  const dismiss = () => {
    entryProblem.value = null;
  };
  return (
    <div class="banners" aria-live="polite">
      <AboardBanner />
      {message && (
        <p class="banner">
          <strong>{t("message.says")}</strong> <bdi>{message}</bdi>
          {endsMs !== null && (
            <span> {t("message.until", { when: whenWords(endsMs, Date.now()) })}</span>
          )}
        </p>
      )}
      {noWayIn && <p class="banner is-problem">{said(noWayIn)}</p>}
      {entryProblem.value && (
        <p class="banner is-problem">
          <span>{said(entryProblem.value)}</span>
          <button type="button" onClick={dismiss}>
            {t("message.understood")}
          </button>
        </p>
      )}
    </div>
  );
}
