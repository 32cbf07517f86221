/** What the server says, in the reader's language: it comes as a code with values. */

import { signal } from "@preact/signals";
import type { Sentence } from "../messages";
import { named } from "./named";
import { type Code, fill, isOurs, language, type Message, t } from "./words";

/** What a language has for the server's codes. */
export type SaidCatalog = Readonly<Record<string, Message>>;

/**
 * What is to be said, put into words only where it is shown: words that come later, or another
 * language, are seen at once. `english` is the server's own, where it came along.
 */
export interface Saying extends Sentence {
  english?: string;
}

/** What needs no words but its value, and what is said when no server gives any more words. */
const NO_WORDS: SaidCatalog = {
  says: "{text}",
  "by.named": "{name}",
  "door.goodbye": "The server is restarting or was switched off.",
};

/** The server's words, once they are loaded: the first picture does not wait for them. */
const english = signal<SaidCatalog>(NO_WORDS);

/** Loads the server's words; until then it is quoted in English where that came along. */
export async function loadSaid(): Promise<SaidCatalog> {
  english.value = (await import("../generated/sentences.json")).default;
  return english.value;
}

/**
 * The sentence in words. A code that the language lacks is English. One that this page has never
 * heard of, since the server is newer, is at least its values; "…" while words are on their way.
 */
export function said(sentence: Saying): string;
export function said(sentence: Saying | null | undefined): string | null;
export function said(sentence: Saying | null | undefined): string | null {
  if (!sentence) return null;
  const { tag, said: own } = language.value;
  const { code, values = {} } = sentence;
  const words = Object.fromEntries(
    Object.entries(values).map(([name, value]) => [name, inWords(value)]),
  );
  const message = own?.[code] ?? english.value[code];
  if (message !== undefined) return fill(message, words, tag);
  if (sentence.english) return sentence.english;
  if (isOurs(code)) return t(code, words);
  if (english.value === NO_WORDS) return "…";
  return Object.values(words).join(", ") || t("link.unknown");
}

/** Whether there are words for this code, once they are loaded. */
export function isCode(code: string): boolean {
  return Object.hasOwn(english.value, code);
}

function inWords(value: string | number | Sentence): string | number {
  if (typeof value === "object") return said(value);
  return typeof value === "string" ? named(value) : value;
}

/** Whether this came as a sentence. */
export function isSentence(one: unknown): one is Sentence {
  return typeof (one as Sentence | null)?.code === "string";
}

/** One of the page's own sentences, to be said later. */
export function ours(code: Code, values?: Sentence["values"]): Saying {
  return values ? { code, values } : { code };
}

/** Words that are nobody's code, as a sentence: they are shown as they are. */
export function says(text: string): Sentence {
  return { code: "says", values: { text } };
}
