import { readdirSync, readFileSync } from "node:fs";
import { join } from "node:path";
import { parseAst } from "vite";
import { expect, it } from "vitest";

const SOURCES = join(import.meta.dirname, "..");
/** Neither the page's own, nor written by hand, nor said to anybody. */
const ELSEWHERE = /^(words|generated|testing)\/|\.test\.tsx?$/;
/** Strings for the browser, and those only for a log or the next `catch`. */
const UNSEEN_ATTRIBUTES = new Set(["class", "rel"]);
const UNSEEN = new Set(["Error", "DOMException"]);
const TWO_WORDS = /\p{L}{2} \p{L}{2}/u;
/** Holders' names, a code of the server's, and the program's name. */
const NO_WORDS = new Set(["gamepad stick", "talk button", "ended by the host", "WAX"]);

interface Node {
  type: string;
  [key: string]: unknown;
}

const nameIn = (node: unknown) => (node as { name?: unknown } | undefined)?.name as string;

/** A program's texts that may reach a reader: any within elements, elsewhere two words or more. */
function* texts(node: unknown): Generator<string> {
  if (Array.isArray(node)) for (const one of node) yield* texts(one);
  if (typeof node !== "object" || node === null || Array.isArray(node)) return;
  const { type, ...inside } = node as Node;
  if (type === "JSXAttribute" && UNSEEN_ATTRIBUTES.has(nameIn(inside.name))) return;
  if (type === "NewExpression" && UNSEEN.has(nameIn(inside.callee))) return;
  if (type === "JSXText" && /\p{L}/u.test(String(inside.value))) yield String(inside.value).trim();
  if (type === "Literal" && TWO_WORDS.test(String(inside.value))) yield String(inside.value);
  const written = (inside.value as { cooked?: string } | null)?.cooked ?? "";
  if (type === "TemplateElement" && TWO_WORDS.test(written)) yield written;
  for (const inner of Object.values(inside)) yield* texts(inner);
}

const parsed = (source: string) => parseAst(source, { lang: "tsx" });

it("finds sentences in text, attributes, strings and templates only", () => {
  const source = `const a = <p class="one two" title="Say it">{t("a.b")} Hello{why ?? \`was \${n} here now\`}</p>;
    const b = why === null ? "it is gone" : "is-gone"; throw new Error("never seen by anybody");`;
  expect([...texts(parsed(source))]).toEqual(["Say it", "Hello", " here now", "it is gone"]);
});

it("has no English for readers outside of words/", () => {
  const found = readdirSync(SOURCES, { recursive: true, encoding: "utf8" })
    .filter((path) => /\.tsx?$/.test(path) && !ELSEWHERE.test(path))
    .flatMap((path) => [...texts(parsed(readFileSync(join(SOURCES, path), "utf8")))]);
  expect(found.filter((text) => !NO_WORDS.has(text))).toEqual([]);
});
