/** Which languages the page has, which one a user gets, and changing between them. */

import { effect, type ReadonlySignal, untracked } from "@preact/signals";
import type { Preferences } from "../preferences";
import { ENGLISH, type Language, language, t } from "./words";

/** A language with its own name, as people look for it in a list; loaded only when used. */
export interface Spoken {
  tag: string;
  name: string;
  load(): Promise<Language>;
}

export const LANGUAGES: readonly Spoken[] = [
  { tag: "en", name: "English", load: async () => ENGLISH },
  {
    tag: "de",
    name: "Deutsch",
    load: async () => (await import("./de")).german,
  },
];

/** Shows what translations do to the page; only by `?lang=pseudo`. */
const TRIAL = "pseudo";

/** The sources of a wish for a language, the strongest first. */
export interface Wishes {
  /** What was chosen on this device; null for nothing. */
  chosen: string | null;
  /** The address's query. */
  search: string;
  /** What the host has set for the page, if anything. */
  host: string | undefined;
  /** The browser's, the most wanted first. */
  browser: readonly string[];
}

/** Returns the first wished language that the page has, else English. Pure. */
export function choose({ chosen, search, host, browser }: Wishes): string {
  const asked = new URLSearchParams(search).get("lang");
  if (asked === TRIAL) return TRIAL;
  for (const wish of [chosen, asked, host, ...browser]) {
    const tag = wish ? spoken(wish) : null;
    if (tag !== null) return tag;
  }
  return ENGLISH.tag;
}

/** The page's language for this tag, as `de` for `de-AT`; null if it has none. */
function spoken(wish: string): string | null {
  const [tag = ""] = wish.toLowerCase().split("-");
  return LANGUAGES.some((one) => one.tag === tag) ? tag : null;
}

/** The wishes of this page and browser. */
export function wishes(chosen: string | null): Wishes {
  return {
    chosen,
    search: window.location.search,
    host: document.documentElement.dataset.language,
    browser: navigator.languages,
  };
}

let newest = 0;

/**
 * Switches the page to this language once it is loaded; resolves to false if that fails, which
 * keeps the previous language. Of several calls the last one counts.
 */
export async function speak(tag: string): Promise<boolean> {
  const call = ++newest;
  let loaded: Language;
  try {
    loaded = await load(tag);
  } catch {
    return call !== newest;
  }
  if (call !== newest) return true;
  language.value = loaded;
  document.documentElement.lang = loaded.tag;
  document.documentElement.dir = loaded.direction;
  return true;
}

async function load(tag: string): Promise<Language> {
  if (tag === TRIAL) return (await import("./pseudo")).makePseudo();
  return LANGUAGES.find((one) => one.tag === tag)?.load() ?? ENGLISH;
}

/** A language's name in that language. */
export function nameOf(tag: string): string {
  return LANGUAGES.find((one) => one.tag === tag)?.name ?? tag;
}

/**
 * Switches to the wished language, now and after each change; says so if it cannot be loaded. While
 * `waits` nothing is loaded.
 */
export function listenLanguage(
  preferences: ReadonlySignal<Preferences>,
  waits: ReadonlySignal<boolean>,
  say: (sentence: string) => void,
): void {
  let wished: string | null = null;
  let told: string | null = null;
  effect(() => {
    const tag = choose(wishes(preferences.value.language));
    if (tag === wished) {
      told = null;
      return;
    }
    if (tag !== ENGLISH.tag && waits.value) {
      if (told !== tag) untracked(() => say(t("language.waits", { language: nameOf(tag) })));
      told = tag;
      return;
    }
    wished = tag;
    told = null;
    void speak(tag).then((isSpoken) => {
      if (isSpoken) return;
      wished = null; // so that the same choice tries again
      say(t("language.not_loaded", { language: nameOf(tag) }));
    });
  });
}
