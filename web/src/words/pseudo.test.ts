import { describe, expect, it } from "vitest";
import { all as everything } from "./en";
import { makePseudo, pseudo } from "./pseudo";
import { fill } from "./words";

/** Its visible text, without marks of direction and placeholders. */
const seen = (text: string) => text.replace(/[\u202a-\u202e\u2066-\u2069]|\{\w+\}/g, "");
const templates = (message: unknown) =>
  typeof message === "string" ? [message] : Object.values(message as Record<string, string>);
const all = Object.values(everything).flatMap(templates);

describe("the pseudo-language", () => {
  it("keeps every placeholder in its place", () => {
    const holes = (text: string) => text.match(/\{\w+\}/g);
    for (const one of all) expect(holes(pseudo(one))).toEqual(holes(one));
    expect(fill(pseudo("{a}: to {b}"), { a: "1", b: "2" }, "ar")).toMatch(/^1.*2/);
  });

  it("is two fifths longer than English, and not much more", () => {
    for (const one of all) {
      const least = seen(one).length * 1.4;
      expect(seen(pseudo(one)).length).toBeGreaterThanOrEqual(Math.floor(least));
      expect(seen(pseudo(one)).length).toBeLessThan(least + 1);
    }
  });

  it("leaves no English word as it was", () => {
    for (const one of all) expect(seen(pseudo(one))).not.toMatch(/[aeiou]/i);
  });

  it("runs from right to left between its values, with balanced marks", () => {
    expect(pseudo("x{a}m")).toMatch(/^\u202ex\u202c\{a\}\u202em\u202c/);
    for (const one of all) {
      const text = pseudo(one);
      expect(text.split("\u202e")).toHaveLength(text.split("\u202c").length);
    }
  });

  it("has each message in each plural form", () => {
    const { tag, direction, messages } = makePseudo();
    expect(direction).toBe("rtl");
    expect(Object.keys(messages)).toEqual(Object.keys(everything));
    const forms = Object.keys(messages["turn.waiting"] ?? {}).toSorted();
    expect(forms).toEqual(new Intl.PluralRules(tag).resolvedOptions().pluralCategories.toSorted());
    const one = (n: number) => seen(fill(messages["turn.waiting"] ?? "", { n }, tag));
    expect(one(1)).not.toContain("1");
    expect(one(3)).toContain("3");
  });
});
