// @vitest-environment dom
import { signal } from "@preact/signals";
import { afterEach, describe, expect, it, vi } from "vitest";
import type { Preferences } from "../preferences";
import { eventually } from "../testing/eventually";
import {
  followLanguageChoice,
  LANGUAGES,
  languageName,
  languageWishes,
  pickLanguage,
  switchLanguage,
} from "./language";
import { ENGLISH, language, t } from "./words";

const NONE = { chosen: null, search: "", host: undefined, browser: [] };

afterEach(async () => {
  vi.doUnmock("./de");
  vi.resetModules();
  await switchLanguage("en");
});

describe("the language", () => {
  it("is what was chosen here, before all else", () => {
    const all = { chosen: "en", search: "?lang=de", host: "de", browser: ["de"] };
    expect(pickLanguage(all)).toBe("en");
  });

  it("is the address's, then the host's, then the browser's", () => {
    expect(
      pickLanguage({ ...NONE, search: "?view=big-screen&lang=de", host: "en", browser: ["en"] }),
    ).toBe("de");
    expect(pickLanguage({ ...NONE, host: "de", browser: ["en"] })).toBe("de");
    expect(pickLanguage({ ...NONE, browser: ["fr-CH", "de-CH", "en"] })).toBe("de");
  });

  it("is English if no wished one is available", () => {
    expect(pickLanguage(NONE)).toBe("en");
    expect(pickLanguage({ chosen: "", search: "?lang=", host: "", browser: ["fr", "tlh"] })).toBe(
      "en",
    );
    expect(pickLanguage({ ...NONE, chosen: "constructor", search: "?lang=__proto__" })).toBe("en");
  });

  it("is the pseudo-language only if the address asks for it", () => {
    expect(pickLanguage({ ...NONE, chosen: "de", search: "?lang=pseudo" })).toBe("pseudo");
    expect(
      pickLanguage({ chosen: "pseudo", search: "", host: "pseudo", browser: ["pseudo"] }),
    ).toBe("en");
  });

  it("is recognised with its country and in any letter case", () => {
    expect(pickLanguage({ ...NONE, chosen: "DE-at" })).toBe("de");
  });
});

it("reads the wishes from the page", () => {
  document.documentElement.dataset.language = "de";
  expect(languageWishes("en")).toMatchObject({
    chosen: "en",
    host: "de",
    browser: navigator.languages,
  });
  delete document.documentElement.dataset.language;
  expect(languageWishes(null).host).toBeUndefined();
});

it("sets the page's language and direction for the browser", async () => {
  expect(await switchLanguage("de")).toBe(true);
  expect(t("turn.you_drive")).toBe("Du fährst");
  expect(document.documentElement).toMatchObject({ lang: "de", dir: "ltr" });
  await switchLanguage("en");
  expect(t("turn.you_drive")).toBe("You are driving");
  expect(document.documentElement.lang).toBe("en");
});

it("can be from right to left", async () => {
  expect(await switchLanguage("pseudo")).toBe(true);
  expect(t("turn.you_drive")).toContain("\u202e");
  expect(document.documentElement.dir).toBe("rtl");
  await switchLanguage("en");
  expect(document.documentElement.dir).toBe("ltr");
});

it("uses the last of several choices, whichever loads first", async () => {
  await Promise.all([switchLanguage("de"), switchLanguage("en")]);
  expect(language.value).toBe(ENGLISH);
});

it("has its own name for every language", () => {
  expect(LANGUAGES.map(({ tag }) => languageName(tag))).toEqual(LANGUAGES.map(({ name }) => name));
});

describe("a page", () => {
  const preferences = (chosen: string | null) => signal({ language: chosen } as Preferences);

  it("uses the wished language, and follows each change", async () => {
    const wished = preferences("de");
    followLanguageChoice(wished, signal(false), () => {});
    await eventually(() => expect(language.value.tag).toBe("de"));
    wished.value = { ...wished.value, language: "en" };
    await eventually(() => expect(language.value.tag).toBe("en"));
  });

  it("loads no language while driving needs its link, says so once per wish, and loads it later", async () => {
    const wished = preferences("en");
    const waits = signal(true);
    const say = vi.fn();
    followLanguageChoice(wished, waits, say);
    wished.value = { ...wished.value, language: "de" };
    wished.value = { ...wished.value, volume: 0.5 };
    expect(say).toHaveBeenCalledExactlyOnceWith(
      "The page speaks Deutsch once your turn is over: your connection is needed for driving.",
    );
    await vi.dynamicImportSettled();
    expect(language.value.tag).toBe("en");
    wished.value = { ...wished.value, language: "en" };
    wished.value = { ...wished.value, language: "de" };
    expect(say).toHaveBeenCalledTimes(2);
    waits.value = false;
    await eventually(() => expect(language.value.tag).toBe("de"));
  });

  it("stays as it is if a language cannot be loaded, says so, and retries", async () => {
    vi.doMock("./de", () => {
      throw new Error("no network");
    });
    const say = vi.fn();
    const wished = preferences("de");
    followLanguageChoice(wished, signal(false), say);
    await eventually(() =>
      expect(say).toHaveBeenCalledExactlyOnceWith(
        "The page could not be loaded in Deutsch; it stays as it is.",
      ),
    );
    expect(t("turn.you_drive")).toBe("You are driving");
    vi.doUnmock("./de");
    wished.value = { ...wished.value };
    await eventually(() => expect(t("turn.you_drive")).toBe("Du fährst"));
  });
});
