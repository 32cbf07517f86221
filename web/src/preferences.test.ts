import { expect, it } from "vitest";
import { DRIVE_DEFAULTS } from "./drive/drivePreferences";
import { loadPreferences, openStore, savePreferences } from "./preferences";

function store(kept: string | null = null) {
  return {
    kept,
    getItem() {
      return this.kept;
    },
    setItem(_key: string, value: string) {
      this.kept = value;
    },
  };
}

const FORBIDDEN = () => {
  throw new DOMException("denied", "SecurityError");
};

it("restores what was saved", () => {
  const mine = store();
  const chosen = {
    name: "Ada",
    sound: false,
    picture: false,
    cameras: false,
    size: "320x240",
    policy: "video-first",
    speed: "fast",
    path: false,
    welcomed: true,
    tells: true,
    player: "built-in",
    language: "de",
    volume: 0.4,
    muted: true,
    ...DRIVE_DEFAULTS,
    way: "step",
    stepMs: 600,
    keys: { ...DRIVE_DEFAULTS.keys, forward: ["KeyZ"] },
  } as const;
  savePreferences(mine, chosen);
  expect(loadPreferences(mine)).toEqual(chosen);
});

it("knows the built-in player by its former name", () => {
  expect(loadPreferences(store('{"player": "own"}')).player).toBe("built-in");
});

it.each([
  null,
  "",
  "no JSON",
  "[]",
  "7",
  "null",
  '{"name": 7, "sound": "yes", "speed": "warp", "policy": "thesis", "player": 1, "language": ["de"], "volume": 7, "muted": 1, "tells": 1}',
])("starts with the defaults when it finds %j", (kept) => {
  expect(loadPreferences(store(kept))).toEqual({
    name: "",
    sound: true,
    picture: true,
    cameras: true,
    size: "",
    policy: null,
    speed: "slow",
    path: true,
    welcomed: false,
    tells: false,
    player: null,
    language: null,
    volume: 1,
    muted: false,
    ...DRIVE_DEFAULTS,
  });
});

it("works without a store", () => {
  expect(openStore(FORBIDDEN)).toBeNull();
  savePreferences(null, loadPreferences(null));
  savePreferences({ getItem: FORBIDDEN, setItem: FORBIDDEN }, loadPreferences(null));
  expect(loadPreferences({ getItem: FORBIDDEN, setItem: FORBIDDEN }).speed).toBe("slow");
});
