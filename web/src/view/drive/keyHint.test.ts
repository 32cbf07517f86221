import { expect, it } from "vitest";
import { readKeyCaps } from "../../drive/keyCaps";
import { DEFAULT_KEYS, keysInForce } from "../../drive/keyMap";
import { loadPreferences } from "../../preferences";
import { hello, planar } from "../../testing/messages";
import { keyHint } from "./keyHint";

const MINE = loadPreferences(null);
const keys = { ...DEFAULT_KEYS, forward: ["KeyE"], stop: ["Space", "KeyX"] };

it.each([
  ["as they come", {}, hello(), "Arrow keys or W A S D drive, Space stops."],
  [
    "with a voice and cameras",
    {},
    hello({ voice: { open_microphone: false }, cameras: [{ name: "Door", axes: [] }] }),
    "Arrow keys or W A S D drive, T speaks, C swaps cameras, Space stops.",
  ],
  ["of one's own", { keys }, hello(), "E ↓ ← → drive, Space stops."],
  ["where a direction has none", { keys: { ...keys, left: [] } }, hello(), "Space stops."],
  ["of one switch", { way: "scan" as const }, hello(), "Enter chooses, Space stops."],
  [
    "of two switches",
    { way: "scan" as const, switches: 2 as const },
    hello(),
    "Enter chooses, N moves on, Space stops.",
  ],
  [
    "of a robot that moves sideways",
    {},
    planar(hello()),
    "Arrow keys or W A S D drive, Q E move sideways, Space stops.",
  ],
  [
    "of one that is moved sideways with Shift",
    { keys: { ...keys, lateral_left: ["Shift+ArrowLeft"], lateral_right: ["Shift+ArrowRight"] } },
    planar(hello()),
    "E ↓ ← → drive, Shift+← Shift+→ move sideways, Space stops.",
  ],
  ["before the greeting", {}, null, "Arrow keys or W A S D drive, Space stops."],
])("says the keys %s", (_, change, greeting, sentence) => {
  const mine = { ...MINE, ...change };
  const inForce = keysInForce(mine.keys, (greeting?.robot.max_lateral_mps ?? 0) > 0);
  expect(keyHint(mine, inForce, greeting)).toBe(sentence);
});

it("says the letters of a French keyboard", async () => {
  const layout = new Map([..."QWAZ"].map((code, at) => [`Key${code}`, "azqw".charAt(at)]));
  await readKeyCaps({ keyboard: { getLayoutMap: async () => layout } });
  const words = keyHint(MINE, DEFAULT_KEYS, planar(hello()));
  expect(words).toBe("Arrow keys or Z Q S D drive, A E move sideways, Space stops.");
});
