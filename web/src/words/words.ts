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

/** A language that the page speaks; `tag` is BCP 47, for the browser and for `Intl`. */
export interface Language {
  tag: string;
  direction: "ltr" | "rtl";
  messages: Catalog;
  /** What the server says, by its codes (`said.ts`); English where it lacks one. */
  said?: Readonly<Record<string, Message>>;
}

/** What English has, as far as it is loaded. */
const english: Partial<Record<Code, Message>> = { ...first };

export const ENGLISH: Language = { tag: "en", direction: "ltr", messages: english };

/** Adds English that came with the part of the page that says it. */
export function learn(more: Catalog): void {
  Object.assign(english, more);
}

/** Loads the English of the parts that are loaded late. */
export async function learnLater(): Promise<void> {
  learn((await import("./en/later.json")).default);
}

/** The language in use: views that read a sentence are drawn again when it changes. */
export const language = signal<Language>(ENGLISH);

/** The sentence with this code, with its values in place. */
export function t(code: Code, values: Values = {}): string {
  const { tag, messages } = language.value;
  return fill(messages[code] ?? english[code] ?? code, values, tag);
}

/** Whether this is one of the page's own codes, as far as its English is loaded. */
export function isOurs(code: string): code is Code {
  return Object.hasOwn(english, code);
}

/** A number in the language's digits, not grouped; with so many decimals, or as many as it has. */
export function figure(value: number, decimals?: number): string {
  return value.toLocaleString(language.value.tag, {
    useGrouping: false,
    ...(decimals === undefined
      ? {}
      : { minimumFractionDigits: decimals, maximumFractionDigits: decimals }),
  });
}

/** How the reader writes times and days: the language, as it is used in their country if known. */
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

/** A value that keeps its own order in a language from right to left: a name, "640 × 480". */
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
