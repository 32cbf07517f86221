// @vitest-environment dom
import {
  findByRole,
  findByText,
  getByRole,
  getByText,
  queryAllByRole,
  queryByRole,
} from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, expect, it, vi } from "vitest";
import type { TapeContent, TapePart } from "../messages";
import { eventually } from "../testing/eventually";
import { Replay } from "./Replay";

const body = document.body;

afterEach(() => {
  act(() => render(null, body));
});

function part(name: string): TapePart {
  return { name, began_wall_ms: 0, size_bytes: 1_000_000, kept: null };
}

function content(name: string, more: Partial<TapeContent> = {}): TapeContent {
  return {
    name,
    began_wall_ms: 0,
    length_ms: 20_000,
    has_media: false,
    has_picture: false,
    has_sound: false,
    cameras: [],
    events: [
      {
        at_ms: 5000,
        event: { type: "stopped", number: 1, pressed: true, viewer: 2, by_host: false },
      },
    ],
    problem: null,
    ...more,
  };
}

const STEERED = {
  type: "steered",
  turn: 1,
  linear_mps: 0.5,
  angular_rps: 0,
  wanted_linear_mps: 0.5,
  wanted_angular_rps: 0,
  reason: null,
  limit: null,
} as const;

/** Answers by path with these; anything else is an error with a sentence. */
function serve(answers: Record<string, unknown>): void {
  vi.stubGlobal("fetch", async (path: string) => {
    const found = answers[path];
    return new Response(JSON.stringify(found ?? { error: "It was deleted meanwhile." }), {
      status: found ? 200 : 404,
    });
  });
  act(() => render(<Replay />, body));
}

it("opens the newest part and seeks to an event of it", async () => {
  serve({
    "api/tape": { parts: [part("old"), part("new")] },
    "api/tape/new": content("new"),
    "api/tape/old": content("old"),
  });
  const stop = await findByRole(body, "button", { name: /Stop pressed by viewer 2/ });
  expect((getByRole(body, "combobox", { name: "Part" }) as HTMLSelectElement).value).toBe("new");
  act(() => stop.click());
  await findByText(body, "Stopped by viewer 2");
  expect((getByRole(body, "slider", { name: "Time" }) as HTMLInputElement).value).toBe("5000");
});

it.each([
  ["no plot of the speed sideways for a tape without it", {}, 0],
  ["a plot of the speed sideways that a tape has", { wanted_lateral_mps: 0.3 }, 1],
])("shows %s", async (_, more, count) => {
  const event = { ...STEERED, ...more };
  serve({
    "api/tape": { parts: [part("one")] },
    "api/tape/one": content("one", { events: [{ at_ms: 1000, event }] }),
  });
  await findByRole(body, "img", { name: "Forward" });
  expect(queryAllByRole(body, "img", { name: "Sideways to the left" }).length).toBe(count);
});

it("enlarges a camera by a tap and by a key, and says when it shows nothing", async () => {
  const cameras = [
    { number: 1, name: "Door", began_ms: 0 },
    { number: 3, name: "Tail", began_ms: 4000 },
  ];
  serve({ "api/tape": { parts: [part("one")] }, "api/tape/one": content("one", { cameras }) });
  const door = await findByRole(body, "button", { name: "Make Door large" });
  const sources = [...body.querySelectorAll("video")].map((one) => one.getAttribute("src"));
  expect(sources).toEqual([null, "media/one/1", "media/one/3"]);
  expect(body.querySelectorAll(".is-missing").length).toBe(1);
  act(() => door.click());
  expect(queryByRole(body, "button", { name: "Make Door large" })).toBeNull();
  const press = (target: EventTarget) =>
    act(() => {
      target.dispatchEvent(new KeyboardEvent("keydown", { key: "c", bubbles: true }));
    });
  press(window);
  expect(queryByRole(body, "button", { name: "Make Tail large" })).toBeNull();
  press(window);
  expect(queryByRole(body, "button", { name: "Make Driving view large" })).toBeNull();
  act(() => getByRole(body, "button", { name: /Stop pressed by viewer 2/ }).click());
  await eventually(() => expect(body.querySelectorAll(".is-missing").length).toBe(0));
});

it("steps to the next event with a key", async () => {
  serve({ "api/tape": { parts: [part("one")] }, "api/tape/one": content("one") });
  await findByRole(body, "button", { name: "Next event" });
  // The page listens only once it has been drawn.
  await eventually(() => {
    act(() => {
      window.dispatchEvent(new KeyboardEvent("keydown", { key: "n" }));
    });
    expect(getByText(body, "Stopped by viewer 2")).toBeTruthy();
  });
});

it("says what is wrong with a part, and plays the rest of it", async () => {
  const problem = "The events are cut off after 5.0 s.";
  serve({ "api/tape": { parts: [part("one")] }, "api/tape/one": content("one", { problem }) });
  expect((await findByRole(body, "alert")).textContent).toBe(problem);
  expect(await findByRole(body, "button", { name: "Play" })).toBeTruthy();
});

it("says why a part cannot be opened", async () => {
  serve({ "api/tape": { parts: [part("gone")] } });
  expect((await findByRole(body, "alert")).textContent).toBe("It was deleted meanwhile.");
  expect(queryByRole(body, "button", { name: "Play" })).toBeNull();
});

it("says that nothing answers", async () => {
  vi.stubGlobal("fetch", async () => {
    throw new TypeError("network");
  });
  act(() => render(<Replay />, body));
  expect((await findByRole(body, "alert")).textContent).toContain("does not answer");
});
