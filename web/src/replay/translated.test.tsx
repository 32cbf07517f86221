// @vitest-environment dom
import { findByRole } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { TapeContent, TapePart } from "../messages";
import { switchLanguage } from "../words/language";
import { loadSaid } from "../words/said";
import { Replay } from "./Replay";

const body = document.body;
/** Text in the pseudo-language; units and key labels are not translated. */
const TRANSLATED = /\u202e[^\u202c]*\u202c|\bms\b|\u2068[A-Z]\u2069/g;

beforeEach(async () => {
  await Promise.all([loadSaid(), switchLanguage("pseudo")]);
});

afterEach(async () => {
  act(() => render(null, body));
  await switchLanguage("en");
});

type Events = TapeContent["events"];

const COMMAND = {
  type: "commanded",
  viewer: 2,
  held: true,
  linear: 1,
  angular: -1,
  axes: {},
  speed: "slow",
  age_ms: 10,
  refused: null,
};
const UNSENT = { round_trip_ms: 9, rendition: null, why: null };
const STEERED = { type: "steered", linear_mps: 0, angular_rps: 0, limit: null };

/** One of everything that is shown in words; names and figures are not translated. */
const EVENTS = [
  [0, { type: "turned", number: 1, operator: 2, why: null }],
  [0, COMMAND],
  [0, { ...STEERED, reason: "too_old" }],
  [0, { type: "reported", connected: true, problem: null, moving: true, bumpers: 1, battery_v: 8 }],
  [0, { type: "watched", viewer: 2, drives: true, picture_ms: 9, sound_ms: null, ...UNSENT }],
  [500, { type: "stopped", number: 1, pressed: true, viewer: 2, by_host: false }],
  [600, { ...STEERED, reason: "pressed" }],
  [700, { type: "stopped", number: 2, pressed: true, viewer: 2, by_host: true }],
  [800, { type: "stopped", number: 2, pressed: false, viewer: 2, by_host: true }],
  [900, { type: "faulted", operator: 2, why: "robot" }],
  [1000, { type: "missed", missed_s: 2 }],
  [1100, { type: "turned", number: 1, operator: null, why: "gone" }],
  [1200, { type: "turned", number: 2, operator: 3, why: null }],
].map(([at_ms, event]) => ({ at_ms, event })) as unknown as Events;

function part(name: string, kept: TapePart["kept"]): TapePart {
  return { name, began_wall_ms: 0, size_bytes: 1_000_000, kept };
}

async function opens(has: Partial<TapeContent>): Promise<void> {
  const content = {
    name: "1",
    began_wall_ms: 0,
    length_ms: 20_000,
    has_media: false,
    has_picture: false,
    has_sound: false,
    cameras: [{ number: 1, name: "7", began_ms: 9000 }],
    events: EVENTS,
    problem: null,
    ...has,
  } as TapeContent;
  const answers: Record<string, unknown> = {
    "api/tape": { parts: [part("0", "host"), part("2", "operator"), part("1", "fault")] },
    "api/tape/1": content,
  };
  vi.stubGlobal("fetch", async (path: string) => new Response(JSON.stringify(answers[path])));
  act(() => render(<Replay />, body));
  await findByRole(body, "slider");
}

/** Everything that a person reads, or has read to them. */
function read(): string[] {
  const found: string[] = [];
  for (const element of body.querySelectorAll<HTMLElement>("*")) {
    for (const name of ["aria-label", "title"]) found.push(element.getAttribute(name) ?? "");
    for (const node of element.childNodes) {
      if (node.nodeType === Node.TEXT_NODE) found.push(node.textContent ?? "");
    }
  }
  return found;
}

/** The untranslated letters in it. */
const plain = () => read().filter((text) => /[a-z]/i.test(text.replace(TRANSLATED, "")));

it("everything is in the reader's language, at every moment", async () => {
  await opens({});
  expect(read().length).toBeGreaterThan(40);
  expect(plain()).toEqual([]);
  for (const button of body.querySelectorAll<HTMLElement>(".replay-marks button")) {
    act(() => button.click());
    expect(plain()).toEqual([]);
  }
  const view = body.querySelectorAll("select")[2];
  if (!view) throw new Error("nothing chooses whose moment is shown");
  act(() => {
    view.value = "seen";
    view.dispatchEvent(new Event("change"));
  });
  expect(plain()).toEqual([]);
});

it("says there that a part is empty, too", async () => {
  await opens({ events: [], cameras: [] });
  expect(plain()).toEqual([]);
});

it("says there that nothing answers", async () => {
  vi.stubGlobal("fetch", async () => {
    throw new TypeError("network");
  });
  act(() => render(<Replay />, body));
  await findByRole(body, "alert");
  expect(plain()).toEqual([]);
});
