import type { Opening } from "../messages";
import { locale, t } from "../words/words";
import { TIME } from "./pageWords";

/** A week of opening hours in local time, and as a calendar file. */
export function Hours({ openings }: { openings: readonly Opening[] }) {
  const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
  return (
    <>
      <p id="ended-hours">{t("link.hours", { zone })}</p>
      {/* biome-ignore lint/a11y/noRedundantRoles: without its marks Safari takes it for no list */}
      <ul role="list" aria-labelledby="ended-hours">
        {openings.map((one) => (
          <li key={one.opens_wall_ms}>{openingWords(one)}</li>
        ))}
      </ul>
      <a href="open.ics">{t("link.calendar")}</a>
    </>
  );
}

/** From when until when it is open, in the reader's own time: `Friday 18:00 – Saturday 01:00`. */
function openingWords({ opens_wall_ms, closes_wall_ms }: Opening): string {
  const where = locale();
  const opens = new Date(opens_wall_ms);
  const closes = new Date(closes_wall_ms);
  const time = (at: Date) => at.toLocaleTimeString(where, TIME);
  // Two calls, because one for both formats the hours differently from a time alone.
  const dayAndTime = (at: Date) =>
    `${at.toLocaleDateString(where, { weekday: "long" })} ${time(at)}`;
  const isSameDay = opens.toDateString() === closes.toDateString();
  return t("when.from_to", {
    from: dayAndTime(opens),
    to: isSameDay ? time(closes) : dayAndTime(closes),
  });
}
