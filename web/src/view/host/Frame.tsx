import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { ask } from "../../link/http";
import { t } from "../../words/words";
import { ToCopy } from "./ToCopy";

/** The line of HTML that shows this robot on another site, where the host lets a site do that. */
export function Frame() {
  const line = useSignal<unknown>(null);
  useEffect(() => {
    const about = document.querySelector<HTMLLinkElement>('link[type="application/json+oembed"]');
    if (!about) return;
    // By the way that this page came: its public address may be another origin.
    ask(`oembed${new URL(about.href).search}`).then(
      ({ html }) => {
        line.value = html;
      },
      () => {}, // it is in the README, too
    );
  }, [line]);
  if (typeof line.value !== "string") return null;
  return (
    <section class="host-section" aria-labelledby="frame-title">
      <h3 id="frame-title">{t("embed.title")}</h3>
      <ToCopy name={t("embed.line")} text={line.value} />
    </section>
  );
}
