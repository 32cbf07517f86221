/**
 * The page's sentences in the reader's language.
 *
 * A message is a template: `{name}` takes a value, and where a number decides the form, a message
 * has one template for each of `Intl.PluralRules`' categories, chosen by the value `n`. A message
 * that a language lacks is English.
 */

import { signal } from "@preact/signals";
import type { all } from "./en";
import first from "./en/first.json";

export type Code = keyof typeof all;
export type Values = Readonly<Record<string, string | number>>;
/** One template, or one for each plural category; `other` is always there. */
export type Message = string | Readonly<{ other: string } & Partial<Record<Plural, string>>>;
export type Catalog = Readonly<Partial<Record<Code, Message>>>;
type Plural = "zero" | "one" | "two" | "few" | "many" | "other";

/** A language of the page; `tag` is BCP 47, for the browser and for `Intl`. */
export interface Language {
  tag: string;
  direction: "ltr" | "rtl";
  messages: Catalog;
  /** The server's sentences by code (`said.ts`); English where one is missing. */
  said?: Readonly<Record<string, Message>>;
}

/** The English messages loaded so far. */
const english: Partial<Record<Code, Message>> = { ...first };

export const ENGLISH: Language = { tag: "en", direction: "ltr", messages: english };

/** Adds the English messages of a part of the page that was loaded late. */
export function addEnglish(more: Catalog): void {
  Object.assign(english, more);
}

/** Loads the English messages of the parts that are loaded late. */
export async function loadLaterEnglish(): Promise<void> {
  addEnglish((await import("./en/later.json")).default);
}

/** The language in use; views that read a sentence are redrawn when it changes. */
export const language = signal<Language>(ENGLISH);

/** The sentence with this code, with its values in place. */
export function t(code: Code, values: Values = {}): string {
  const { tag, messages } = language.value;
  return fill(messages[code] ?? english[code] ?? code, values, tag);
}

/** Whether this is one of the page's own codes, among those loaded so far. */
export function isPageCode(code: string): code is Code {
  return Object.hasOwn(english, code);
}

/** A number in the language's digits, ungrouped; with `decimals`, or as many as it has. */
export function figure(value: number, decimals?: number): string {
  return value.toLocaleString(language.value.tag, {
    useGrouping: false,
    ...(decimals === undefined
      ? {}
      : { minimumFractionDigits: decimals, maximumFractionDigits: decimals }),
  });
}

/** The locale for times and days: the language, as used in the reader's country if known. */
export function locale(): string {
  const { tag } = language.value;
  return navigator.languages.find((one) => one.split("-")[0] === tag) ?? tag;
}

/** Puts values into a message; numbers are written as the language writes them. */
export function fill(message: Message, values: Values, tag: string): string {
  const template = typeof message === "string" ? message : chosen(message, values.n, tag);
  return template.replace(/\{(\w+)\}/g, (hole, name: string) => {
    const value = values[name];
    if (value === undefined) return hole;
    return apart(typeof value === "number" ? value.toLocaleString(tag) : value);
  });
}

/** Isolates a value, such as a name or "640 × 480", so that it keeps its order in RTL text. */
function apart(value: string): string {
  return language.value.direction === "rtl" && value !== "" ? `\u2068${value}\u2069` : value;
}

function chosen(
  message: Exclude<Message, string>,
  n: string | number | undefined,
  tag: string,
): string {
  if (typeof n !== "number") return message.other;
  return message[new Intl.PluralRules(tag).select(n)] ?? message.other;
}
