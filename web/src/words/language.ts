/** Which languages the page has, which one a user gets, and changing between them. */

import { effect, type ReadonlySignal, untracked } from "@preact/signals";
import type { Preferences } from "../preferences";
import { ENGLISH, type Language, language, t } from "./words";

/** A language with its own name, as people look for it in a list; loaded only when used. */
export interface PageLanguage {
  tag: string;
  name: string;
  load(): Promise<Language>;
}

export const LANGUAGES: readonly PageLanguage[] = [
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
export interface LanguageWishes {
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
export function pickLanguage({ chosen, search, host, browser }: LanguageWishes): string {
  const asked = new URLSearchParams(search).get("lang");
  if (asked === TRIAL) return TRIAL;
  for (const wish of [chosen, asked, host, ...browser]) {
    const tag = wish ? available(wish) : null;
    if (tag !== null) return tag;
  }
  return ENGLISH.tag;
}

/** The page's language for this tag, as `de` for `de-AT`; null if it has none. */
function available(wish: string): string | null {
  const [tag = ""] = wish.toLowerCase().split("-");
  return LANGUAGES.some((one) => one.tag === tag) ? tag : null;
}

/** The wishes of this page and browser. */
export function languageWishes(chosen: string | null): LanguageWishes {
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
export async function switchLanguage(tag: string): Promise<boolean> {
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
export function languageName(tag: string): string {
  return LANGUAGES.find((one) => one.tag === tag)?.name ?? tag;
}

/**
 * Switches to the wished language, now and after each change; says so if it cannot be loaded. While
 * `waits` nothing is loaded.
 */
export function followLanguageChoice(
  preferences: ReadonlySignal<Preferences>,
  waits: ReadonlySignal<boolean>,
  say: (sentence: string) => void,
): void {
  let wished: string | null = null;
  let told: string | null = null;
  effect(() => {
    const tag = pickLanguage(languageWishes(preferences.value.language));
    if (tag === wished) {
      told = null;
      return;
    }
    if (tag !== ENGLISH.tag && waits.value) {
      if (told !== tag) untracked(() => say(t("language.waits", { language: languageName(tag) })));
      told = tag;
      return;
    }
    wished = tag;
    told = null;
    void switchLanguage(tag).then((isLoaded) => {
      if (isLoaded) return;
      wished = null; // so that the same choice tries again
      say(t("language.not_loaded", { language: languageName(tag) }));
    });
  });
}
