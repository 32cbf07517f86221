import { expect, it } from "vitest";
import { sample } from "../testing/samples";
import { History, MOST_MARKS, MOST_SAMPLES } from "./history";

it("returns what was added, oldest first, and null for unknown values", () => {
  const history = new History();
  expect(history.newestMs).toBeNull();
  history.add(sample(1000, { pictureMs: 40, skewMs: -3 }));
  history.add(sample(2000, { pictureMs: null, skewMs: 0 }));
  expect(history.times()).toEqual([1000, 2000]);
  expect(history.column("pictureMs")).toEqual([40, null]);
  expect(history.column("skewMs")).toEqual([-3, 0]);
  expect(history.newestMs).toBe(2000);
  expect(history.since("pictureMs", 0)).toEqual([40]);
  expect(history.since("pictureMs", 1001)).toEqual([]);
});

it("keeps only the newest samples, however long the page is open", () => {
  const history = new History();
  for (let i = 0; i < 3 * MOST_SAMPLES + 7; i++) history.add(sample(i * 1000, { soundMs: i }));
  expect(history.length).toBe(MOST_SAMPLES);
  const sounds = history.column("soundMs");
  expect(sounds).toHaveLength(MOST_SAMPLES);
  expect(sounds[0]).toBe(2 * MOST_SAMPLES + 7);
  expect(sounds.at(-1)).toBe(3 * MOST_SAMPLES + 6);
  expect(history.times().at(-1)).toBe((3 * MOST_SAMPLES + 6) * 1000);
});

it("accepts at most four samples a second", () => {
  const history = new History();
  const taken = Array.from({ length: 100 }, (_, i) => history.add(sample(i * 50)));
  expect(taken.filter(Boolean)).toHaveLength(20);
});

it("keeps only the newest marks", () => {
  const history = new History();
  for (let i = 0; i < MOST_MARKS + 5; i++) history.mark({ atMs: i, kind: "sent", text: `${i}` });
  expect(history.marks).toHaveLength(MOST_MARKS);
  expect(history.marks[0]?.text).toBe("5");
});
