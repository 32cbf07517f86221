import { expect, it } from "vitest";
import { type FakePad, pad, push } from "../testing/gamepads";
import { type Found, PadLearner } from "./padLearner";

const REST = [0, 0, 0, -1, 9 / 7];

/** What is found while these positions of the axes follow one another, each 100 ms. */
function found(positions: readonly number[][], isAxis: boolean, begins = REST): Found | null {
  const on = pad({ axes: [...begins] });
  const learner = new PadLearner(on, isAxis);
  for (const [step, axes] of positions.entries()) {
    on.axes = axes;
    const part = learner.next(on, 100 * step);
    if (part) return part;
  }
  return null;
}

const at = (axis: number, value: number) => REST.map((rest, i) => (i === axis ? value : rest));

it("finds a button by a press that began meanwhile", () => {
  const on: FakePad = pad();
  push(on, 0);
  const learner = new PadLearner(on, false);
  expect(learner.next(on, 0)).toBeNull();
  push(on, 5);
  expect(learner.next(on, 50)).toMatchObject({ kind: "button", at: 5 });
  push(on, 5, 0);
  push(on, 0, 0);
  expect(learner.next(on, 100)).toBeNull();
  push(on, 0);
  expect(learner.next(on, 150)).toMatchObject({ kind: "button", at: 0 });
});

it("takes no button for an axis", () => {
  const on = pad();
  const learner = new PadLearner(on, true);
  push(on, 5);
  expect(learner.next(on, 0)).toBeNull();
});

it.each([
  ["a stick that springs back", [at(1, -0.4), at(1, -1), at(1, -0.6), at(1, 0)], 1, -1, 0],
  ["a throttle that stays", [0, 0.5, 1, 1, 1, 1, 1, 1, 1].map((one) => at(3, one)), 3, 1, -1],
  ["a hat", [at(4, -1), at(4, 9 / 7)], 4, -1, 9 / 7],
])("finds %s by the end to which it was pushed", (_, positions, axis, to, from) => {
  expect(found(positions, axis !== 4)).toEqual({ kind: "axis", at: axis, to, from });
});

it("finds nothing while a stick trembles, or is on its way", () => {
  expect(found([at(0, 0.4), at(0, -0.4), at(0, 0)], true)).toBeNull();
  const slow = Array.from({ length: 12 }, (_, step) => at(0, -0.5 - step / 25));
  expect(found(slow, true)).toBeNull();
});

it("finds the end of a pad that has fewer axes by now", () => {
  expect(found([at(4, 0), []], true)).toMatchObject({ at: 4, to: 0 });
  expect(found([[]], true)).toBeNull();
});
