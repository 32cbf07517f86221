/** What the server says, in the reader's language: it comes as a code with values. */

import { signal } from "@preact/signals";
import type { Sentence } from "../messages";
import { named } from "./named";
import { fill, language, type Message, t } from "./words";

/** What a language has for the server's codes. */
export type SaidCatalog = Readonly<Record<string, Message>>;

/** The server's own words, once they are loaded: the first picture does not wait for them. */
const english = signal<SaidCatalog>({});

/** Loads the server's words; where that fails, what it says is told in general words. */
export async function loadSaid(): Promise<SaidCatalog> {
  english.value = (await import("../generated/sentences.json")).default;
  return english.value;
}

/**
 * The sentence in words. A code that the language lacks is English; one that this page has never
 * heard of, since the server is newer, is at least its values.
 */
export function said(sentence: Sentence): string;
export function said(sentence: Sentence | null | undefined): string | null;
export function said(sentence: Sentence | null | undefined): string | null {
  if (!sentence) return null;
  const { tag, said: own } = language.value;
  const { code, values = {} } = sentence;
  const words = Object.fromEntries(
    Object.entries(values).map(([name, value]) => [name, inWords(value)]),
  );
  const message = own?.[code] ?? english.value[code];
  if (message !== undefined) return fill(message, words, tag);
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

/** Words that are nobody's code, as a sentence: they are shown as they are. */
export function says(text: string): Sentence {
  return { code: "says", values: { text } };
}
