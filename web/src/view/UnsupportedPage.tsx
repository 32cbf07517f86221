import type { Lacks } from "../support";
import { t } from "../words/words";

/** The page for a browser that cannot show the robot: what it lacks, and what to do. */
export function UnsupportedPage({ lacks }: { lacks: Lacks }) {
  const { webrtc, channels, parts } = lacks;
  return (
    <main class="ended">
      <p class="brand">WAX</p>
      <div role="alert">
        <h1>{t("support.cannot")}</h1>
        {webrtc && <p>{t("support.no_webrtc")}</p>}
        {channels && <p>{t("support.no_channels")}</p>}
        {parts.length > 0 && <p>{t("support.too_old", { parts: parts.join(", ") })}</p>}
      </div>
      {webrtc && <p>{t("support.switched_off")}</p>}
      <p>{t("support.what_to_do")}</p>
    </main>
  );
}
