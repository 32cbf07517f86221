/**
 * A pseudo-language that shows what a translation does to the page: English from right to left, two
 * fifths longer, and with accents, which reveal untranslated text. Generated when needed, so that
 * it is always complete.
 */

import english from "../generated/sentences.json";
import { all as everything } from "./en";
import type { Language, Message } from "./words";

/** Latin digits, so that figures stay comparable; XB is no country's code. */
const TAG = "ar-XB-u-nu-latn";
const LONGER_BY = 0.4;

const PLAIN = "ABCDEGHIJKLNORSTUWYZabcdeghijklnorstuwyz";
const ACCENTED = "ÅƁÇÐÉĜĤÎĴĶĻÑÖŔŠŢÛŴÝŽåƀçðéĝĥîĵķļñöŕšţûŵýž";
const VOWEL = /[aeiouy]/i;
/** The text between these runs from right to left, whatever its letters. */
const RIGHT_TO_LEFT = ["\u202e", "\u202c"] as const;

/** Returns a template in the pseudo-language; its placeholders stay as they are. Pure. */
export function pseudo(template: string): string {
  const [begin, end] = RIGHT_TO_LEFT;
  let owed = 0;
  const parts = template.split(/(\{\w+\})/).map((part, at) => {
    const isHole = at % 2 === 1;
    if (isHole || part === "") return part;
    let longer = "";
    for (const letter of part) {
      owed += LONGER_BY;
      const more = VOWEL.test(letter) ? Math.floor(owed) : 0;
      owed -= more;
      longer += accented(letter).repeat(1 + more);
    }
    return `${begin}${longer}${end}`;
  });
  const missing = "~".repeat(Math.ceil(owed - 1e-9));
  return missing ? `${parts.join("")}${begin}${missing}${end}` : parts.join("");
}

function accented(letter: string): string {
  return ACCENTED[PLAIN.indexOf(letter)] ?? letter;
}

/** A message with all of Arabic's plural forms, made from English's two. */
function inEveryForm(message: Exclude<Message, string>): Message {
  const { pluralCategories } = new Intl.PluralRules(TAG).resolvedOptions();
  const forms = pluralCategories.map((form) => [form, pseudo(message[form] ?? message.other)]);
  return { other: pseudo(message.other), ...Object.fromEntries(forms) };
}

function all(messages: Readonly<Record<string, Message>>): Record<string, Message> {
  const made = Object.entries(messages).map(([code, message]) => [
    code,
    typeof message === "string" ? pseudo(message) : inEveryForm(message),
  ]);
  return Object.fromEntries(made);
}

export function makePseudo(messages: Readonly<Record<string, Message>> = everything): Language {
  return { tag: TAG, direction: "rtl", messages: all(messages), said: all(english) };
}
