import { beforeAll, expect, it } from "vitest";
import type { Commanded, Placed, TapeContent, Watched } from "../messages";
import { loadSaid } from "../words/said";
import { Timeline } from "./timeline";

beforeAll(() => loadSaid());

type Event = Placed["event"];

function tape(events: [number, Event][], lengthMs = 60_000): TapeContent {
  return {
    name: "wax-1",
    began_wall_ms: 0,
    length_ms: lengthMs,
    has_media: true,
    has_picture: true,
    has_sound: true,
    cameras: [],
    events: events.map(([at_ms, event]) => ({ at_ms, event })),
    problem: null,
  };
}

function commanded(more: Partial<Commanded> = {}): Commanded {
  return {
    type: "commanded",
    viewer: 1,
    seq: 1,
    turn: 1,
    age_ms: 50,
    seen_age_ms: 200,
    linear: 1,
    angular: 0,
    held: true,
    speed: "fast",
    axes: {},
    refused: null,
    ...more,
  };
}

function watched(more: Partial<Watched> = {}): Watched {
  return {
    type: "watched",
    viewer: 1,
    drives: true,
    round_trip_ms: 40,
    picture_ms: 300,
    picture_held_ms: null,
    sound_ms: 500,
    sound_held_ms: null,
    rendition: "640x480",
    picture_hz: 30,
    sound_mu_ms: 20,
    link_bps: 1_000_000,
    queue_ms: 0,
    why: null,
    ...more,
  };
}

const TURN: Event = { type: "turned", number: 1, operator: 1, why: null };
const STOP: Event = { type: "stopped", number: 4, pressed: true, viewer: 2, by_host: false };

it("knows who drives and which command counts at each moment", () => {
  const line = new Timeline(
    tape([
      [0, TURN],
      [1000, commanded()],
      [1100, commanded({ seq: 2, linear: 0.5 })],
      [1200, commanded({ seq: 3, refused: "too_old" })],
    ]),
  );
  expect(line.operatorAt(500)).toBe(1);
  expect(line.commandAt(999)).toBeNull();
  expect(line.commandAt(1000)?.linear).toBe(1);
  expect(line.commandAt(1250)?.seq).toBe(2);
  expect(line.commandAt(9000)).toBeNull();
});

it("shows the operator's input at its time, even if the command was refused", () => {
  const line = new Timeline(
    tape([
      [0, TURN],
      [1200, commanded({ seq: 3, age_ms: 400, refused: "too_old" })],
      [1210, commanded({ viewer: 9, age_ms: 0 })],
    ]),
  );
  expect(line.sentAt(799)).toBeNull();
  expect(line.sentAt(800)?.seq).toBe(3);
  expect(line.sentAt(1300)?.viewer).toBe(1);
});

it("finds the moment in which the operator saw a picture", () => {
  const line = new Timeline(
    tape([
      [0, TURN],
      [1000, watched({ picture_ms: 300 })],
      [2000, watched({ picture_ms: 400 })],
      [2000, watched({ viewer: 9, drives: false, picture_ms: 9000 })],
    ]),
  );
  expect(line.whenSeen(1200, "pictureMs")).toBe(1500);
  expect(line.whenSeen(2200, "pictureMs")).toBe(2600);
  expect(line.agesAt(2100)).toEqual({ pictureMs: 400, soundMs: 500 });
  // Before the first report nothing is known or made up.
  expect(line.agesAt(500)).toEqual({ pictureMs: 0, soundMs: 0 });
});

it("marks stops, faults and turns, and steps from one to the next", () => {
  const line = new Timeline(
    tape([
      [0, TURN],
      [0, STOP],
      [5000, { ...STOP, pressed: false }],
      [8000, { type: "faulted", operator: 1, why: "too_old" }],
      [9000, { type: "missed", missed_s: 1.5 }],
    ]),
  );
  // The state before the part began is not an event of it.
  expect(line.marks.map((mark) => mark.kind)).toEqual(["stop", "fault", "gap"]);
  expect(line.stopAt(100)?.number).toBe(4);
  expect(line.stopAt(6000)).toBeNull();
  expect(line.next(0)?.atMs).toBe(5000);
  expect(line.next(5000)?.words).toBe(
    "Stopped by a fault: the operator reads “Your commands do not arrive in time: your connection is slow.”",
  );
  expect(line.previous(8000)?.atMs).toBe(5000);
  expect(line.previous(5000)).toBeNull();
  expect(line.next(9000)).toBeNull();
});

it("names people only if names were recorded", () => {
  const line = new Timeline(
    tape([
      [0, { type: "named", viewer: 2, name: "Ada" }],
      [10, STOP],
    ]),
  );
  expect(line.marks[0]?.words).toBe("Stop pressed by Ada");
  expect(line.who(7)).toBe("viewer 7");
  expect(line.who(null)).toBe("nobody");
});

it("counts as at an event when the video was sent there", () => {
  const timeline = new Timeline(tape([[3000.123456, STOP]]));
  expect(timeline.stopAt(3000.123)).toEqual(STOP);
  expect(timeline.stopAt(3000.1)).toBeNull();
});
