import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { expect, it } from "vitest";
import { all } from "./words/en";
import en from "./words/en/first.json";
import later from "./words/en/later.json";

const ROOT = import.meta.dirname;
/** Modules loaded before anything else, without types and `import(…)`. */
const STATIC = /^(?:import|export) (?!type )(?:[^"']*? from )?"([^"]+)";$/gm;

/** Every module and package that the page loads at once. */
function loadedBy(path: string, found = new Set<string>()): Set<string> {
  if (found.has(path)) return found;
  found.add(path);
  for (const [, name = ""] of readFileSync(path, "utf8").matchAll(STATIC)) {
    if (!name.startsWith(".")) found.add(name);
    else if (!/\.(css|json)$|\?|generated/.test(name))
      loadedBy(resolve(dirname(path), name), found);
  }
  return found;
}

function resolve(folder: string, name: string): string {
  for (const end of [".ts", ".tsx", "/index.ts"]) {
    try {
      readFileSync(join(folder, name + end));
      return join(folder, name + end);
    } catch {
      // Another end, then.
    }
  }
  throw new Error(`${name} is not in ${folder}`);
}

it("leaves what few pages need out of the first load", () => {
  const loaded = [...loadedBy(join(ROOT, "main.tsx"))];
  expect(loaded).toContain("preact");
  expect(loaded).toContain(join(ROOT, "measure/report.ts"));
  expect(loaded).not.toContain("livekit-client");
  for (const folder of ["rooms", "bigScreen", "embed", "glass", "replay", "path", "headset"]) {
    expect(loaded.filter((one) => one.startsWith(join(ROOT, folder)))).toEqual([]);
  }
  expect(loaded).not.toContain(join(ROOT, "view/host/HostPanel.tsx"));
  expect(loaded).not.toContain(join(ROOT, "view/drive/ControlSet.tsx"));
  expect(loaded).not.toContain(join(ROOT, "view/drive/WaysPanel.tsx"));
  expect(loaded).not.toContain(join(ROOT, "view/RulesPanel.tsx"));
  expect(loaded).not.toContain(join(ROOT, "view/Watching.tsx"));
  expect(loaded).not.toContain(join(ROOT, "view/UnsupportedPage.tsx"));
  const hosts = [...loadedBy(join(ROOT, "view/host/HostPanel.tsx"))];
  expect(hosts).toContain(join(ROOT, "view/host/Calibration.tsx"));
  expect(hosts).not.toContain(join(ROOT, "view/host/Calibrate.tsx"));
  expect(hosts).not.toContain(join(ROOT, "path/solve.ts"));
  const later = [...loadedBy(join(ROOT, "rooms/roomViewer.ts"))];
  expect(later).toContain("livekit-client");
});

it("leaves languages other than English out of the first load", () => {
  const loaded = [...loadedBy(join(ROOT, "main.tsx"))];
  const words = loaded.filter((one) => one.startsWith(join(ROOT, "words")));
  const first = ["language.ts", "lateWords.ts", "named.ts", "said.ts", "words.ts"].map((name) =>
    join(ROOT, "words", name),
  );
  expect(words.toSorted()).toEqual(first);
});

/** Every message that one of these modules may show. */
function saidBy(modules: Iterable<string>): string[] {
  const sources = [...modules].filter((one) => one.startsWith(ROOT));
  const text = sources.map((path) => readFileSync(path, "utf8")).join("\n");
  return Object.keys(all).filter((code) => text.includes(`"${code}"`));
}

it("has exactly the words of the first load and of driving", () => {
  const first = loadedBy(join(ROOT, "main.tsx"));
  // Loaded without further words: what driving needs, and what watches LiveKit rooms.
  for (const path of ["view/drive/ControlSet.tsx", "view/Watching.tsx", "rooms/roomViewer.ts"])
    loadedBy(join(ROOT, path), first);
  const said = saidBy(first).filter((code) => !code.startsWith("replay."));
  expect(said.toSorted()).toEqual(Object.keys(en).toSorted());
  expect(said.filter((code) => code in later)).toEqual([]);
});

it("records the history from the start, and loads the plots on demand", () => {
  const loaded = [...loadedBy(join(ROOT, "main.tsx"))];
  expect(loaded).not.toContain("uplot");
  expect(loaded).not.toContain("lean-qr");
  expect([...loadedBy(join(ROOT, "bigScreen/BigScreen.tsx"))]).toContain("lean-qr");
  expect([...loadedBy(join(ROOT, "embed/Embed.tsx"))]).not.toContain("lean-qr");
  const ofStats = loaded.filter((one) => one.startsWith(join(ROOT, "stats")));
  const needed = ["stats/history.ts", "stats/record.ts"].map((path) => join(ROOT, path));
  expect(ofStats.toSorted()).toEqual(needed);
  expect([...loadedBy(join(ROOT, "view/Stats.tsx"))]).not.toContain("uplot");
  expect([...loadedBy(join(ROOT, "stats/StatsPage.tsx"))]).toContain("uplot");
});
