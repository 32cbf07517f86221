import { afterEach, describe, expect, it, vi } from "vitest";
import { de } from "./de";
import { ENGLISH, figure, fill, type Language, language, locale, t } from "./words";

const GERMAN: Language = { tag: "de", direction: "ltr", messages: de };

afterEach(() => {
  language.value = ENGLISH;
});

describe("a message", () => {
  it("takes its values wherever their placeholders are", () => {
    expect(fill("{b} {a} {b}", { a: "x", b: "y" }, "en")).toBe("y x y");
  });

  it("keeps a placeholder without a value, to show what is missing", () => {
    expect(fill("from {who}", {}, "en")).toBe("from {who}");
  });

  it("takes a value as it is, even if it looks like a placeholder", () => {
    expect(fill("{a} {b}", { a: "{b}", b: "$&" }, "en")).toBe("{b} $&");
  });

  it("writes numbers as the language does, and text as it is", () => {
    expect(fill("{n}", { n: 1234.5 }, "en")).toBe("1,234.5");
    expect(fill("{n}", { n: 1234.5 }, "de")).toBe("1.234,5");
    expect(fill("{n}", { n: "1234.5" }, "de")).toBe("1234.5");
  });

  it("has the language's plural form", () => {
    const message = { one: "{n} Katze", few: "{n} kočky", other: "{n} Katzen" };
    expect([1, 2, 5].map((n) => fill(message, { n }, "de"))).toEqual([
      "1 Katze",
      "2 Katzen",
      "5 Katzen",
    ]);
    expect(fill(message, { n: 2 }, "cs")).toBe("2 kočky");
  });

  it("has its general form without a number", () => {
    expect(fill({ one: "one", other: "some" }, {}, "en")).toBe("some");
    expect(fill({ one: "one", other: "some" }, { n: "1" }, "en")).toBe("some");
  });
});

describe("the page", () => {
  it("uses the chosen language", () => {
    expect(t("turn.you_drive")).toBe("You are driving");
    language.value = GERMAN;
    expect(t("turn.you_drive")).toBe("Du fährst");
    expect(t("turn.waiting", { n: 1 })).toBe("Eine Person wartet.");
    expect(t("turn.waiting", { n: 2000 })).toBe("2.000 Personen warten.");
  });

  it("keeps each value's order in a right-to-left language", () => {
    language.value = {
      tag: "he",
      direction: "rtl",
      messages: { "stop.by": "{name} \u05e2\u05e6\u05e8" },
    };
    expect(t("stop.by", { name: "Ada 2" })).toBe("\u2068Ada 2\u2069 \u05e2\u05e6\u05e8");
    expect(t("stop.by", { name: "" })).toBe(" \u05e2\u05e6\u05e8");
  });

  it("falls back to English if a language lacks a message", () => {
    language.value = { ...GERMAN, messages: {} };
    expect(t("turn.you_drive")).toBe("You are driving");
  });
});

it("writes figures with the language's own decimal sign, ungrouped", () => {
  expect([figure(1234), figure(0.35), figure(12, 1)]).toEqual(["1234", "0.35", "12.0"]);
  language.value = GERMAN;
  expect([figure(1234), figure(0.35), figure(12, 1)]).toEqual(["1234", "0,35", "12,0"]);
});

it("writes times as in the reader's country, if that uses the page's language", () => {
  vi.stubGlobal("navigator", { languages: ["fr-FR", "de-AT", "en-GB"] });
  expect(locale()).toBe("en-GB");
  language.value = GERMAN;
  expect(locale()).toBe("de-AT");
  vi.stubGlobal("navigator", { languages: ["fr-FR"] });
  expect(locale()).toBe("de");
});
