import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { afterEach, describe, expect, it, vi } from "vitest";
import { german } from "./de";
import { LANGUAGES } from "./language";
import { makePseudo } from "./pseudo";
import { isSentence, loadSaid, type SaidCatalog, said, says } from "./said";
import { ENGLISH, language, type Message } from "./words";

afterEach(() => {
  language.value = ENGLISH;
});

const templates = (message: Message) =>
  typeof message === "string" ? [message] : Object.values(message);

const holes = (template: string) =>
  [...template.matchAll(/\{(\w+)\}/g)].map(([, name]) => name).toSorted();

const general = (message: Message) => (typeof message === "string" ? message : message.other);

const SAID_ENGLISH: SaidCatalog = await loadSaid();
const ALL = await Promise.all(LANGUAGES.map(({ load }) => load()));
/** Every language but English. */
const OTHERS = [...ALL.filter((one) => one !== ENGLISH), makePseudo()];

describe.each(OTHERS)("what the server says, in $tag", ({ tag, said: own = {} }) => {
  it("has every code of the server, and no other", () => {
    expect(Object.keys(own).toSorted()).toEqual(Object.keys(SAID_ENGLISH).toSorted());
  });

  it("has a placeholder for each value, in each of its forms", () => {
    for (const [code, english] of Object.entries(SAID_ENGLISH)) {
      const message = own[code] ?? "";
      expect({ code, holes: holes(general(message)) }).toEqual({
        code,
        holes: holes(general(english)),
      });
      for (const one of templates(message)) {
        for (const hole of holes(one)) expect(holes(general(english))).toContain(hole);
      }
    }
  });

  it("has each plural form of the language where English has more than one", () => {
    const { pluralCategories } = new Intl.PluralRules(tag).resolvedOptions();
    for (const [code, english] of Object.entries(SAID_ENGLISH)) {
      if (typeof english === "string") continue;
      const forms = Object.keys(own[code] ?? {}).toSorted();
      expect({ code, forms }).toEqual({ code, forms: pluralCategories.toSorted() });
    }
  });

  it("has text, without surrounding spaces", () => {
    const poor = Object.values(own).flatMap(templates);
    expect(poor.filter((one) => one.trim() === "" || one !== one.trim())).toEqual([]);
  });
});

it("is not copied English", () => {
  const same = Object.keys(SAID_ENGLISH).filter(
    (code) => JSON.stringify(german.said?.[code]) === JSON.stringify(SAID_ENGLISH[code]),
  );
  // Only values and units.
  expect(same.toSorted()).toEqual([
    "by.named",
    "camera.named",
    "proof.list",
    "rate.kbit",
    "rate.mbit",
    "says",
  ]);
});

it("has no code that the page uses as its own", () => {
  const folder = join(import.meta.dirname, "..");
  const sources = readdirSync(folder, { recursive: true, encoding: "utf8" })
    .filter((path) => /\.tsx?$/.test(path) && !path.includes(".test."))
    .map((path) => readFileSync(join(folder, path), "utf8"));
  const own = [...sources.join("\n").matchAll(/\bpageSentence\(\s*"([^"]+)"/g)].map(
    ([, code = ""]) => code,
  );
  expect(own).toContain("link.lost");
  expect(own.filter((code) => code in SAID_ENGLISH)).toEqual([]);
});

describe("before the server's words are loaded", () => {
  it.each(OTHERS)("a full robot is reported in $tag, or in the server's words", async (spoken) => {
    vi.resetModules(); // a page that has loaded nothing yet
    const early = await import("./said");
    const { language: speaks } = await import("./words");
    const english = "The only place is taken; try again later.";
    const full = { code: "door.full", values: { n: 1 }, english };
    expect(early.said(full)).toBe(english);
    expect(early.said({ code: "door.full", values: { n: 1 } })).toBe("…");
    expect(early.said(early.says("Come back on Monday."))).toBe("Come back on Monday.");
    expect(early.said(early.pageSentence("link.lost"))).toBe("The connection was lost.");
    speaks.value = spoken;
    const own = spoken.said?.["door.full"] as { one: string };
    expect(early.said(full)).toBe(own.one);
    expect(early.said(early.pageSentence("link.lost"))).toBe(spoken.messages["link.lost"]);
  });
});

it("has the words of a goodbye already, as the server can send no more", async () => {
  vi.resetModules();
  const early = await import("./said");
  expect(early.said({ code: "door.goodbye" })).toBe(SAID_ENGLISH["door.goodbye"]);
});

describe("a sentence of the server's", () => {
  it("is in the reader's language, and follows its changes", () => {
    const sentence = { code: "drive.not_your_turn" };
    expect(said(sentence)).toBe("It is not your turn.");
    language.value = german;
    expect(said(sentence)).toBe("Du bist nicht dran.");
  });

  it("may contain others, and numbers in the language's format", () => {
    const rate = { code: "rate.mbit", values: { rate: 1.2 } };
    const sentence = { code: "sent.carries", values: { rate } };
    expect(said(sentence)).toBe("the link carries about 1.2 Mbit/s");
    language.value = german;
    expect(said(sentence)).toBe("Die Verbindung schafft etwa 1,2 Mbit/s");
  });

  it("has the form for its number", () => {
    const full = (n: number) => said({ code: "door.full", values: { n } });
    expect([full(1), full(30)]).toEqual([
      "The only place is taken; try again later.",
      "All 30 places are taken; try again later.",
    ]);
  });

  it("keeps a right-to-left name in its place", () => {
    expect(said({ code: "voice.taken", values: { name: "אבא" } })).toBe(
      "\u2068אבא\u2069 is speaking; wait until they have finished.",
    );
  });

  it("falls back to English in a language that lacks it", () => {
    language.value = { ...german, said: {} };
    expect(said({ code: "door.closed" })).toBe("The robot is closed.");
  });

  it("shows at least its values, or what to do, if the page does not know the code", () => {
    expect(said({ code: "new.one", values: { text: "The arm is stuck.", n: 3 } })).toBe(
      "The arm is stuck., 3",
    );
    expect(said({ code: "new.one" })).toContain("reload it");
  });

  it("is null for none", () => {
    expect([said(null), said(undefined)]).toEqual([null, null]);
  });

  it("is recognised by its code", () => {
    expect([says("Hm."), { code: "x" }].every(isSentence)).toBe(true);
    expect([null, undefined, "x", 3, {}, { code: 3 }].some(isSentence)).toBe(false);
  });
});
