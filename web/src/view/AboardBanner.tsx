import { said } from "../words/said";
import { t } from "../words/words";
import { useState } from "./context";
import { requestWords } from "./words";

/**
 * Above the picture: what the person aboard asks for, and why nobody but them may drive now. The
 * operator reads that beside their controls.
 */
export function AboardBanner() {
  const { room, request, isConnected, drivingTurn } = useState();
  const aboard = room.value?.aboard;
  if (!aboard || !isConnected.value) return null;
  // A control that does not answer is a problem of the robot, which is shown as such.
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
