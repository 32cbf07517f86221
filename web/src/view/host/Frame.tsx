import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { ask } from "../../link/http";
import { t } from "../../words/words";
import { ToCopy } from "./ToCopy";

/** The line of HTML that embeds this robot in another site, if the host allows that. */
export function Frame() {
  const line = useSignal<unknown>(null);
  useEffect(() => {
    const about = document.querySelector<HTMLLinkElement>('link[type="application/json+oembed"]');
    if (!about) return;
    // Requested from this page's own origin, as the public address may have another.
    ask(`oembed${new URL(about.href).search}`).then(
      ({ html }) => {
        line.value = html;
      },
      () => {}, // the line is in the README, too
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
