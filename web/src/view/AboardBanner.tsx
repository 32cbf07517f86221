import { said } from "../words/said";
import { t } from "../words/words";
import { useState } from "./context";
import { requestWords } from "./pageWords";

/**
 * Above the picture: what the person aboard asks for, and why only they may drive now. The operator
 * reads the latter beside the controls.
 */
export function AboardBanner() {
  const { room, request, isConnected, drivingTurn } = useState();
  const aboard = room.value?.aboard;
  if (!aboard || !isConnected.value) return null;
  // A hand control that does not answer is shown as a problem of the robot.
  const reason = aboard.mode === "lost" || drivingTurn.value !== null ? null : aboard.reason;
  return (
    <>
      {request.value && (
        <p class="banner is-request" role="alert">
          <strong>{t("aboard.from")}</strong> {requestWords(request.value.asked)}
        </p>
      )}
      {reason && <p class="banner is-problem">{said(reason)}</p>}
    </>
  );
}
