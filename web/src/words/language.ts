/** Which languages the page speaks, which of them is for whom, and changing between them. */

import { effect, type ReadonlySignal, untracked } from "@preact/signals";
import type { Preferences } from "../preferences";
import { ENGLISH, type Language, language, t } from "./words";

/** A language in its own words, as people look for it in a list; loaded only for who reads it. */
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

/** To see what translations do to the page; only who asks for it in the address gets it. */
const TRIAL = "pseudo";

/** Where a wish for a language may come from, the strongest first. */
export interface Wishes {
  /** What was chosen on this device; null for nothing. */
  chosen: string | null;
  /** The address's `?…`. */
  search: string;
  /** What the host has set for the page, if anything. */
  host: string | undefined;
  /** The browser's, the most wanted first. */
  browser: readonly string[];
}

/** Returns the language for these wishes: English where none of them is spoken. Pure. */
export function choose({ chosen, search, host, browser }: Wishes): string {
  const asked = new URLSearchParams(search).get("lang");
  if (asked === TRIAL) return TRIAL;
  for (const wish of [chosen, asked, host, ...browser]) {
    const tag = wish ? spoken(wish) : null;
    if (tag !== null) return tag;
  }
  return ENGLISH.tag;
}

/** The page's language for this tag: `de` for `de-AT`; null where it has none. */
function spoken(wish: string): string | null {
  const [tag = ""] = wish.toLowerCase().split("-");
  return LANGUAGES.some((one) => one.tag === tag) ? tag : null;
}

/** The wishes as they are in a page. */
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
 * Has the page speak this language once it is loaded; resolves to false where that fails, and then
 * it speaks on as before. Of several calls the last one counts.
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

/** What a language is called by who speaks it. */
export function nameOf(tag: string): string {
  return LANGUAGES.find((one) => one.tag === tag)?.name ?? tag;
}

/**
 * Has the page speak the language that is wished, now and after each change; says where it cannot.
 * While `waits` nothing is loaded.
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
