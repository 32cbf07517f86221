import { brandedPage } from "../branding/page";
import { t } from "../words/words";
import { useState } from "./context";
import { HouseRules } from "./HouseRules";

/** The host's sentence, rules and links, for the menu. */
export function About() {
  const { sentence, rules, links } = brandedPage(useState());
  const safe = links.filter((one) => isSafe(one.url));
  return (
    <section class="about" aria-labelledby="about-title">
      <h3 id="about-title">{t("branding.about")}</h3>
      <p>
        <bdi>{sentence}</bdi>
      </p>
      <HouseRules rules={rules} />
      {safe.length > 0 && (
        <ul class="page-links" aria-label={t("branding.links")}>
          {safe.map((one) => (
            <li key={one.url}>
              <a href={one.url} target="_blank" rel="noopener noreferrer">
                <bdi>{one.text}</bdi>
              </a>
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}

/**
 * Whether a link may be opened. The server has checked the host's configuration; a page that reads
 * a link from anywhere opens it only as one of these.
 */
function isSafe(url: string): boolean {
  return /^(https?:\/\/|mailto:)/i.test(url);
}
