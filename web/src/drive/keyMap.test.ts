import { describe, expect, it } from "vitest";
import { assign, unassign } from "./assignKey";
import { codeOf } from "./codeOf";
import { actionOf, DEFAULT_KEYS, KEY_ACTIONS, type KeyMap, keysInForce, loadKeys } from "./keyMap";

describe("the default", () => {
  it("has no key twice", () => {
    const all = KEY_ACTIONS.flatMap((action) => DEFAULT_KEYS[action]);
    expect(new Set(all).size).toBe(all.length);
  });

  it("knows what a key does", () => {
    expect(actionOf(DEFAULT_KEYS, "ArrowUp")).toBe("forward");
    expect(actionOf(DEFAULT_KEYS, "Space")).toBe("stop");
    expect(actionOf(DEFAULT_KEYS, "KeyZ")).toBeNull();
  });
});

describe("Shift", () => {
  const keys: KeyMap = {
    ...DEFAULT_KEYS,
    forward: ["KeyW", "Shift+KeyX"],
    stop: ["Space", "KeyX"],
  };

  it("gives a key another action, if it has one, and changes no other key", () => {
    expect(actionOf(keys, "ArrowLeft")).toBe("left");
    expect(actionOf(keys, "ArrowLeft", true)).toBe("lateral_left");
    expect(actionOf(keys, "KeyW", true)).toBe("forward");
    expect(actionOf(keys, "KeyZ", true)).toBeNull();
  });

  it("never takes a key from Stop", () => {
    expect(actionOf(keys, "KeyX", true)).toBe("stop");
    expect(assign(keys, "forward", "Shift+Space")).toEqual({ why: "taken", by: "stop" });
    expect(assign(keys, "back", "Shift+KeyX")).toEqual({ why: "taken", by: "stop" });
  });

  it("can be part of a new key, but not of one that is reserved", () => {
    expect(assign(DEFAULT_KEYS, "lateral_left", "Shift+KeyZ")).toMatchObject({
      keys: { lateral_left: ["KeyQ", "Shift+ArrowLeft", "Shift+KeyZ"] },
    });
    expect(assign(DEFAULT_KEYS, "lateral_left", "Shift+Tab")).toEqual({ why: "reserved" });
    expect(loadKeys({ lateral_left: ["Shift+KeyZ", "Shift+Tab"] }).lateral_left).toEqual([
      "Shift+KeyZ",
    ]);
  });
});

describe("the keys that move sideways", () => {
  const shown = KEY_ACTIONS.filter((one) => !one.startsWith("lateral"));

  it("do nothing on a robot that cannot, where Shift with an arrow turns as ever", () => {
    const keys = keysInForce(DEFAULT_KEYS, false);
    for (const key of ["KeyQ", "KeyE"]) expect(actionOf(keys, key)).toBeNull();
    expect(actionOf(keys, "ArrowLeft", true)).toBe("left");
    expect(keysInForce(DEFAULT_KEYS, true)).toBe(DEFAULT_KEYS);
  });

  it("can be chosen for another action there", () => {
    expect(assign(DEFAULT_KEYS, "forward", "KeyE")).toEqual({ why: "taken", by: "lateral_right" });
    const changed = assign(DEFAULT_KEYS, "forward", "KeyE", shown);
    expect(changed).toMatchObject({
      keys: { forward: ["ArrowUp", "KeyW", "KeyE"], lateral_right: ["Shift+ArrowRight"] },
    });
  });
});

describe("a new key", () => {
  it("is added to the existing ones", () => {
    const changed = assign(DEFAULT_KEYS, "stop", "KeyX");
    expect(changed).toEqual({ keys: { ...DEFAULT_KEYS, stop: ["Space", "KeyX"] } });
  });

  it("changes nothing if the action has it already", () => {
    expect(assign(DEFAULT_KEYS, "forward", "KeyW")).toEqual({ keys: DEFAULT_KEYS });
  });

  it("is refused if another action has it, and names that action", () => {
    expect(assign(DEFAULT_KEYS, "forward", "KeyT")).toEqual({ why: "taken", by: "talk" });
    expect(assign(DEFAULT_KEYS, "forward", "Space")).toEqual({ why: "taken", by: "stop" });
  });

  it("may have a name only, as on an on-screen keyboard", () => {
    const told = codeOf({ code: "", key: "BrowserBack" });
    expect(assign(DEFAULT_KEYS, "stop", told)).toMatchObject({ keys: { stop: ["Space", told] } });
    expect(assign(DEFAULT_KEYS, "stop", codeOf({ code: "", key: "é" }))).toEqual({
      why: "reserved",
    });
  });

  it.each([
    "Shift",
    "Meta",
    "Alt",
    "Control",
    "AltGraph",
    "OS",
    "Tab",
    "Escape",
    "ShiftLeft",
    "ControlRight",
    "AltLeft",
    "MetaLeft",
    "",
    "Key W",
    "Fn",
  ])("is refused where the browser or the system needs it: %j", (key) => {
    expect(assign(DEFAULT_KEYS, "forward", key)).toEqual({ why: "reserved" });
  });

  it("is refused as a fifth", () => {
    const keys = { ...DEFAULT_KEYS, forward: ["KeyW", "ArrowUp", "Numpad8", "KeyZ"] };
    expect(assign(keys, "forward", "KeyY")).toEqual({ why: "too_many" });
  });
});

describe("a removed key", () => {
  it("no longer does anything", () => {
    const changed = unassign(DEFAULT_KEYS, "forward", "KeyW");
    expect(changed).toEqual({ keys: { ...DEFAULT_KEYS, forward: ["ArrowUp"] } });
  });

  it("cannot be Space, which always stops", () => {
    expect(unassign(DEFAULT_KEYS, "stop", "Space")).toEqual({ why: "always_stops" });
  });
});

describe("the stored keys", () => {
  it("are restored", () => {
    const keys = { ...DEFAULT_KEYS, forward: ["KeyZ"], talk: [], stop: ["Space", "KeyX"] };
    expect(loadKeys(JSON.parse(JSON.stringify(keys)))).toEqual(keys);
  });

  it.each([null, undefined, 7, "keys", [], {}])("are the default for %j", (kept) => {
    expect(loadKeys(kept)).toEqual(DEFAULT_KEYS);
  });

  it("keep Space for Stop, and each key for one action", () => {
    const keys = loadKeys({ forward: ["Space", "KeyE", "KeyE"], back: ["KeyE", "KeyQ"], stop: [] });
    expect(keys).toMatchObject({ forward: ["KeyE"], back: ["KeyQ"], stop: ["Space"] });
  });

  it("leave out invalid keys, and the fifth of an action", () => {
    const forward = [7, null, "Escape", "a key", "KeyB", "KeyG", "KeyH", "KeyM", "KeyP"];
    expect(loadKeys({ forward }).forward).toEqual(["KeyB", "KeyG", "KeyH", "KeyM"]);
  });

  it("do not give a new action a key that the user has assigned to another", () => {
    const { recentre, ...older } = DEFAULT_KEYS;
    const keys = loadKeys({ ...older, forward: recentre });
    expect(keys.forward).toEqual(recentre);
    expect(keys.recentre).toEqual([]);
  });
});
