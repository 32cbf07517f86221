import { readdirSync, readFileSync } from "node:fs";
import { basename, join } from "node:path";
import { expect, it } from "vitest";

const SOURCES = join(import.meta.dirname, "..");

const HAIRLINE_PX = 2;
/** A size above the last step reserves room for a part of the page. */
const LAST_STEP_PX = 24;

interface Declaration {
  file: string;
  property: string;
  value: string;
}

function* declarations(): Generator<Declaration> {
  for (const path of readdirSync(SOURCES, { recursive: true, encoding: "utf8" })) {
    if (!path.endsWith(".css")) continue;
    const text = readFileSync(join(SOURCES, path), "utf8");
    for (const [, property = "", value = ""] of text.matchAll(/^\s*([\w-]+):\s*([^;{]+);/gm)) {
      yield { file: basename(path), property, value };
    }
  }
}

const pixels = (value: string) => [...value.matchAll(/([\d.]+)px/g)].map(([, px]) => Number(px));

const told = (found: Iterable<Declaration>) =>
  [...found].map(({ file, property, value }) => `${file}: ${property}: ${value}`);

it("takes every distance from the scale of base.css", () => {
  const distances = [...declarations()].filter(({ property }) =>
    /^((row-|column-)?gap|(padding|margin)(-.*)?|border-radius)$/.test(property),
  );
  expect(distances.length).toBeGreaterThan(100);
  const own = distances.filter(
    ({ value }) =>
      /[\d.]rem/.test(value) || pixels(value).some((px) => px > HAIRLINE_PX && px <= LAST_STEP_PX),
  );
  expect(told(own)).toEqual([]);
});

it("takes every size of type from the scale, the text around it, or the browser's setting", () => {
  const sizes = [...declarations()].filter(({ property }) => /^font(-size)?$/.test(property));
  expect(sizes.length).toBeGreaterThan(30);
  expect(told(sizes.filter(({ value }) => /\d(px|rem)/.test(value)))).toEqual([]);
});
