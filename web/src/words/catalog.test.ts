import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { describe, expect, it } from "vitest";
import { all } from "./en";
import { LANGUAGES } from "./language";
import type { Catalog, Message } from "./words";

const SOURCES = join(import.meta.dirname, "..");
const ENGLISH: Catalog = all;
/** Every language's messages, by its tag. */
const ALL = await Promise.all(
  LANGUAGES.map(async ({ tag, load }) => [tag, (await load()).messages] as const),
);
/** Messages that are the same in English. */
const SAME: Readonly<Record<string, readonly string[]>> = {
  de: [
    "figures.quantity",
    "figures.stereo",
    "headset.enter",
    "panels.details",
    "panels.host",
    "replay.motion",
    "replay.part.size",
    "replay.plot.mps",
    "replay.speed.normal",
    "replay.why",
    "stats.unit.kbps",
    "stats.unit.ms",
    "stats.unit.px",
    "watch.volume.value",
    "ways.pad",
  ],
};

const templates = (message: Message) =>
  typeof message === "string" ? [message] : Object.values(message);

const holes = (template: string) =>
  [...template.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).toSorted();

/** The placeholders of a message's general form, which are all that it may have. */
function holesOf(message: Message): (string | undefined)[] {
  return holes(typeof message === "string" ? message : message.other);
}

describe.each(ALL)("%s", (tag, catalog) => {
  const messages = Object.entries(catalog) as [string, Message][];

  it("has a message for every code, and no other", () => {
    expect(Object.keys(catalog).toSorted()).toEqual(Object.keys(all).toSorted());
  });

  it("has text in every message, without surrounding spaces", () => {
    const poor = messages.filter(([, message]) =>
      templates(message).some((one) => one.trim() === "" || one !== one.trim()),
    );
    expect(poor).toEqual([]);
  });

  it("has the same values as the English", () => {
    for (const [code, message] of messages) {
      const wanted = holesOf(ENGLISH[code as keyof typeof all] ?? "");
      expect({ code, holes: holesOf(message) }).toEqual({ code, holes: wanted });
    }
  });

  it("has each plural form of the language, and no other", () => {
    const { pluralCategories } = new Intl.PluralRules(tag).resolvedOptions();
    const plural = messages.filter(([, message]) => typeof message !== "string");
    expect(plural).not.toEqual([]);
    for (const [code, message] of plural) {
      const forms = Object.keys(message).toSorted();
      expect({ code, forms }).toEqual({ code, forms: pluralCategories.toSorted() });
      // A form may omit the number ("one person"), but has nothing that the general one lacks.
      for (const one of templates(message)) {
        for (const hole of holes(one)) expect(holesOf(message)).toContain(hole);
      }
    }
  });

  it("has the same files and order as English", () => {
    for (const file of ["first.json", "later.json", "replay.json"]) {
      const codes = (language: string) =>
        Object.keys(JSON.parse(readFileSync(join(import.meta.dirname, language, file), "utf8")));
      expect({ file, codes: codes(tag) }).toEqual({ file, codes: codes("en") });
    }
  });
});

describe.each(ALL.filter(([tag]) => tag !== "en"))("%s", (tag, catalog) => {
  it("is not copied English", () => {
    const same = Object.keys(all).filter((code) => {
      const key = code as keyof typeof all;
      return JSON.stringify(catalog[key]) === JSON.stringify(all[key]);
    });
    expect(same.toSorted()).toEqual(SAME[tag] ?? []);
  });
});

it("has no unused message", () => {
  const sources = readdirSync(SOURCES, { recursive: true, encoding: "utf8" })
    .filter((path) => /\.tsx?$/.test(path) && !/\.test\.tsx?$/.test(path))
    .map((path) => readFileSync(join(SOURCES, path), "utf8"))
    .join("\n");
  const unused = Object.keys(all).filter((code) => !sources.includes(`"${code}"`));
  expect(unused).toEqual([]);
});
