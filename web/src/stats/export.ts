/**
 * A file to attach to a bug report: how it played here in the last minutes. Pure.
 *
 * The file, schema 1, has units in its keys, and no names, people's texts or addresses:
 *
 * - `schema`, `schema_version`: "wax-stats" and 1; a reader refuses what it does not know.
 * - `made_wall_ms`: when it was made, in ms since 1970.
 * - `server_version`: of the WAX that served the page, null before its hello.
 * - `browser`: the `user_agent`.
 * - `role`: of the user who exported it: operator, queued or observer; null without a connection.
 * - `why`: the code of the sentence that the page showed, and its values.
 * - `samples`: columns of one length, oldest first; `age_ms` is before `made_wall_ms`. Null where
 *   nothing was known. `FIELDS` in `history.ts` says what each is.
 * - `marks`: what happened: `age_ms`, `kind`, and `text` as the page showed it.
 *
 * A new key keeps the version; a changed meaning or a removed key raises it.
 */

import type { ViewerInfo } from "../messages";
import { stamp } from "../stamp";
import { FIELDS, type Field, type History } from "./history";
import type { Why } from "./why";

export const SCHEMA_VERSION = 1;

export interface About {
  nowMs: number;
  wallMs: number;
  version: string | null;
  userAgent: string;
  role: ViewerInfo["role"] | null;
  why: Why;
}

export function exported(history: History, about: About): object {
  const ageMs = (atMs: number) => Math.round(about.nowMs - atMs);
  return {
    schema: "wax-stats",
    schema_version: SCHEMA_VERSION,
    made_wall_ms: Math.round(about.wallMs),
    server_version: about.version,
    browser: { user_agent: about.userAgent },
    role: about.role,
    why: about.why,
    samples: {
      age_ms: history.times().map(ageMs),
      ...Object.fromEntries(
        FIELDS.map((field) => [keyOf(field), history.column(field).map(rounded)]),
      ),
    },
    marks: history.marks.map(({ atMs, kind, text }) => ({ age_ms: ageMs(atMs), kind, text })),
  };
}

/** `wax-stats-2026-05-04-13-30-00.json`, by the reader's clock. */
export function fileName(wallMs: number): string {
  return `wax-stats-${stamp(new Date(wallMs))}.json`;
}

/** `pictureMs` as `picture_ms`. */
function keyOf(field: Field): string {
  return field.replace(/[A-Z]/g, (letter) => `_${letter.toLowerCase()}`);
}

function rounded(value: number | null): number | null {
  return value === null ? null : Math.round(value * 10) / 10;
}
