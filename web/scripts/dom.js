// Cuts TypeScript's DOM types down to the oldest browsers that the page supports: whatever one of them
// lacks, by MDN's compatibility data, may be undefined, so that using it untested is a type error.
// TypeScript finds the file by its option libReplacement.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname } from "node:path";
import { fileURLToPath } from "node:url";

const OLDEST = { chrome: 110, firefox: 128, safari: 16.4, safari_ios: 16.4 };

/** The APIs that need no test, each with its reason. */
const USED = new Set([
  "AudioDecoder", // only in the decoder's worker, which is started only where the browser has it
  "EncodedAudioChunk", // the same
  "URLSearchParams.size", // the page does not use it, but Node's types demand it in tests
]);

/**
 * @typedef {import("@mdn/browser-compat-data").Identifier} Identifier
 * @typedef {import("@mdn/browser-compat-data").SimpleSupportStatement} Support
 */

/**
 * @param {Support} one
 * @param {number} oldest
 */
function isIn(one, oldest) {
  /** @param {unknown} version */
  const at = (version) => Number.parseFloat(`${version}`.replace("≤", ""));
  if (one.flags || one.prefix || one.alternative_name) return false;
  return at(one.version_added) <= oldest && !(at(one.version_removed) <= oldest);
}

/**
 * The browsers that lack this entry's API; none where there is no entry.
 * @param {Identifier | undefined} entry
 */
function lacking(entry) {
  const support = entry?.__compat?.support;
  if (support === undefined) return [];
  return Object.entries(OLDEST)
    .filter(([name, oldest]) => {
      const found = support[/** @type {keyof typeof OLDEST} */ (name)] ?? [];
      return ![found].flat().some((one) => isIn(one, oldest));
    })
    .map(([name]) => name);
}

/**
 * @param {string} dom TypeScript's lib.dom.d.ts
 * @param {Identifier} api MDN's entries, by interface
 */
export function oldestDom(dom, api) {
  const lines = dom.split("\n");
  /** @type {Map<string, string[]>} the interfaces that inherit from a mixin; MDN lists its members there */
  const heirs = new Map();
  for (const line of lines) {
    const [, heir, bases] = /^interface (\w+).*? extends (.*) \{/.exec(line) ?? [];
    for (const base of bases?.split(/,\s*/) ?? []) {
      const name = base.replace(/<.*/, "");
      heirs.set(name, [...(heirs.get(name) ?? []), heir ?? ""]);
    }
  }
  /**
   * @param {string} owner
   * @param {string} member
   * @returns {string[]}
   */
  function lackingMember(owner, member) {
    if (owner in api) {
      // Where there is one, the browser has the interface.
      const whole = lacking(api[owner]);
      return lacking(api[owner]?.[member]).filter((one) => !whole.includes(one));
    }
    return (heirs.get(owner) ?? []).flatMap((one) => lackingMember(one, member));
  }
  let owner = "";
  let kind = "";
  return lines
    .flatMap((line) => {
      const [, what, found = ""] = /^declare (function|var) (\w+).*;$/.exec(line) ?? [];
      if (what) {
        if (lacking(api.Window?.[found] ?? api[found]).length === 0) return line;
        // A name that may not be there is asked for by way of `window`.
        return what === "var" ? line.replace(": ", ": undefined | ") : [];
      }
      const [, opened, name = ""] = /^(interface|declare var) (\w+).*\{$/.exec(line) ?? [];
      if (opened) {
        [owner, kind] = [name, opened];
        const isMissing = opened === "declare var" && lacking(api[name]).length > 0;
        return isMissing && !USED.has(name) ? line.replace(": {", ": undefined | {") : line;
      }
      const member = /^ {4}(?:readonly )?(\w+)[(<:]/.exec(line)?.[1];
      if (member === undefined || member === "new" || USED.has(`${owner}.${member}`)) return line;
      const key = kind === "interface" ? member : `${member}_static`;
      return lackingMember(owner, key).length > 0 ? line.replace(member, `${member}?`) : line;
    })
    .join("\n");
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const typescript = `@typescript/typescript-${process.platform}-${process.arch}/package.json`;
  const lib = new URL("lib/lib.dom.d.ts", import.meta.resolve(typescript));
  const data = new URL(import.meta.resolve("@mdn/browser-compat-data"));
  const { api } = JSON.parse(readFileSync(data, "utf8"));
  const target = fileURLToPath(
    new URL("../node_modules/@typescript/lib-dom/index.d.ts", import.meta.url),
  );
  mkdirSync(dirname(target), { recursive: true });
  writeFileSync(target, oldestDom(readFileSync(lib, "utf8"), api));
}
