// @vitest-environment dom
import { afterEach, beforeAll, expect, it } from "vitest";
import sentences from "../generated/sentences.json";
import { switchLanguage } from "../words/language";
import { loadSaid } from "../words/said";
import { endWords, reasonWords } from "./reasons";

beforeAll(() => loadSaid());
afterEach(() => switchLanguage("en"));

it("quotes what the operator was told, for every reason of the gate's", () => {
  const codes = Object.keys(sentences).filter((one) => /^(drive|hold|limit)\./.test(one));
  expect(codes.length).toBeGreaterThan(20);
  for (const code of codes) {
    const words = reasonWords(code.split(".")[1] ?? "");
    expect(words).toMatch(/^the operator reads “.+”$/);
  }
  expect(reasonWords("blind")).toContain(sentences["drive.blind"]);
  expect(reasonWords("lapsed")).toContain(sentences["hold.lapsed"]);
});

it("has its own words for reasons without a sentence", () => {
  expect(reasonWords("pressed")).toBe("Stop is pressed");
  expect(reasonWords("robot")).toBe("a reason of the robot's own");
  expect(reasonWords("nobody_drives")).toBe("nobody drives");
  expect(reasonWords("from_the_future")).toBe("from the future");
});

it("says why a turn ended, if the tape knows it", () => {
  expect(endWords("expired")).toBe("its time is over");
  expect(endWords("ended by the host")).toBe("ended by the host");
  expect([endWords(null), endWords("newer")]).toEqual(Array(2).fill("nobody knows why"));
});

it("uses the reader's language", async () => {
  await switchLanguage("de");
  expect(reasonWords("late_picture")).toBe("zu lesen war „Langsam: Das Bild kommt spät.“");
  expect(endWords("idle")).toBe("es wurde nicht gefahren");
});
