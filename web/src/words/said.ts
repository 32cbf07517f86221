/** The server's sentences in the reader's language; they arrive as codes with values. */

import { signal } from "@preact/signals";
import type { Sentence } from "../messages";
import { named } from "./named";
import { type Code, fill, isPageCode, language, type Message, t } from "./words";

/** A language's messages for the server's codes. */
export type SaidCatalog = Readonly<Record<string, Message>>;

/**
 * A sentence that is put into words only where it is shown, so that words loaded later, or another
 * language, apply at once. `english` is the server's own wording, where it was sent along.
 */
export interface Saying extends Sentence {
  english?: string;
}

/** Sentences that are only a value, and one for when no server can provide words any more. */
const NO_WORDS: SaidCatalog = {
  says: "{text}",
  "by.named": "{name}",
  "door.goodbye": "The server is restarting or was switched off.",
};

/** The server's sentences, once they are loaded: the first picture does not wait for them. */
const english = signal<SaidCatalog>(NO_WORDS);

/** Loads the server's sentences; until then, any English sent along is shown. */
export async function loadSaid(): Promise<SaidCatalog> {
  english.value = (await import("../generated/sentences.json")).default;
  return english.value;
}

/**
 * The sentence in words, in English if the language lacks its code. A code unknown to this page,
 * from a newer server, shows at least its values; "…" while the words are being loaded.
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
  if (isPageCode(code)) return t(code, words);
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

/** Whether this is a sentence from the server. */
export function isSentence(one: unknown): one is Sentence {
  return typeof (one as Sentence | null)?.code === "string";
}

/** One of the page's own sentences, to be said later. */
export function pageSentence(code: Code, values?: Sentence["values"]): Saying {
  return values ? { code, values } : { code };
}

/** Plain text as a sentence, shown as it is. */
export function says(text: string): Sentence {
  return { code: "says", values: { text } };
}
