/**
 * A language that nobody speaks, to see what a translation will do to the page: English from right
 * to left, two fifths longer, and with accents, by which one knows what was not translated. Made
 * when it is asked for, so that it is never behind.
 */

import english from "../generated/sentences.json";
import { all as everything } from "./en";
import type { Language, Message } from "./words";

/** Latin digits, so that figures stay comparable; XB is a country of nobody's. */
const TAG = "ar-XB-u-nu-latn";
const LONGER_BY = 0.4;

const PLAIN = "ABCDEGHIJKLNORSTUWYZabcdeghijklnorstuwyz";
const ACCENTED = "ÅƁÇÐÉĜĤÎĴĶĻÑÖŔŠŢÛŴÝŽåƀçðéĝĥîĵķļñöŕšţûŵýž";
const VOWEL = /[aeiouy]/i;
/** The text between is from right to left, whatever its letters are. */
const RIGHT_TO_LEFT = ["\u202e", "\u202c"] as const;

/** Returns a template as that language has it; its holes stay as they are. Pure. */
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

/** Arabic's forms for numbers, all made of the two that English has. */
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
