import { afterEach, expect, it } from "vitest";
import { keyWords, readKeyCaps } from "./keyCaps";

afterEach(() => readKeyCaps({ keyboard: { getLayoutMap: async () => new Map() } }));

it.each([
  ["KeyW", "W"],
  ["Digit1", "1"],
  ["ArrowUp", "↑"],
  ["NumpadEnter", "Numpad Enter"],
  ["Numpad8", "Numpad 8"],
  ["F5", "F5"],
  ["Space", "Space"],
  ["Shift+ArrowLeft", "Shift+←"],
])("%s is printed %s, where the browser does not tell", async (key, words) => {
  await readKeyCaps({});
  await readKeyCaps({
    keyboard: { getLayoutMap: () => Promise.reject(new Error("SecurityError")) },
  });
  expect(keyWords(key)).toBe(words);
});

it("says what a French keyboard has printed on its keys", async () => {
  const layout = new Map(Object.entries({ KeyW: "z", KeyQ: "a", Semicolon: "m", ArrowUp: "?" }));
  await readKeyCaps({ keyboard: { getLayoutMap: async () => layout } });
  const words = ["KeyW", "Shift+KeyQ", "Semicolon", "ArrowUp", "F5"].map(keyWords);
  expect(words).toEqual(["Z", "Shift+A", "M", "↑", "F5"]);
});
