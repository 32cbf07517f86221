import { describe, expect, it } from "vitest";
import type { RoomState } from "../messages";
import { aboard, pressedBy, room, viewer } from "../testing/messages";
import { named } from "../words/named";
import { says } from "../words/said";
import { qualityWords } from "./host/qualityWords";
import {
  connectionWords,
  inOrder,
  joinWords,
  lostWords,
  missedWords,
  placeWords,
  problemWords,
  standingWords,
  stoppedWords,
  turnWords,
  waitWords,
  whenWords,
} from "./pageWords";

it("describes the connection, and when and why it is retried", () => {
  expect(connectionWords({ is: "connected" }, 0)).toBe("Connected");
  const silent = { is: "silent", sinceMs: 5000 } as const;
  expect(connectionWords(silent, 5700)).toBe("No answer for 1 s");
  expect(connectionWords(silent, 7999)).toBe("No answer for 2 s");
  expect(connectionWords({ is: "connecting", reason: null }, 0)).toBe("Connecting…");
  const waiting = { is: "waiting", retryAtMs: 5000, reason: says("The server is full.") } as const;
  expect(connectionWords(waiting, 2001)).toBe("Reconnecting in 3 s: The server is full.");
  expect(connectionWords(waiting, 9000)).toBe("Reconnecting now: The server is full.");
});

it.each([
  [null, ""],
  [0, "any moment now"],
  [10, "any moment now"],
  [24, "about 20 s"],
  [54, "about 50 s"],
  [55, "about 1 min"],
  [89, "about 1 min"],
  [130, "about 2 min"],
])("calls a wait of %s s %j", (waitS, words) => {
  expect(waitWords(waitS)).toBe(words);
});

describe("a line of the queue", () => {
  it("shows who drives, waits and watches", () => {
    expect(placeWords(viewer(1, { role: "operator", place: 0 }))).toBe("driving");
    expect(placeWords(viewer(1, { role: "queued", place: 1, wait_s: 30 }))).toBe(
      "next, about 30 s",
    );
    expect(placeWords(viewer(1, { role: "queued", place: 3, wait_s: 150 }))).toBe(
      "number 3, about 3 min",
    );
    expect(placeWords(viewer(1))).toBe("watching");
  });

  it("marks a lost connection", () => {
    expect(placeWords(viewer(1, { role: "operator", place: 0, lost: true }))).toBe(
      "driving, connection lost",
    );
    expect(placeWords(viewer(1, { role: "queued", place: 2, lost: true }))).toBe(
      "number 2, connection lost",
    );
  });
});

it("lists the operator, the queue by place, then observers by arrival", () => {
  const { viewers } = room({ operator: 4, waiting: [5, 2], watching: [3, 1] });
  expect(inOrder(viewers).map((one) => one.id)).toEqual([4, 5, 2, 1, 3]);
});

describe("the turn", () => {
  const words = (options: Parameters<typeof room>[0], me: number) => {
    const now = room(options);
    return turnWords(now, now.viewers.find((one) => one.id === me) ?? null);
  };

  it("tells the operator that they drive, and who is next", () => {
    expect(words({ operator: 1, waiting: [2] }, 1)).toEqual({
      headline: "You are driving",
      next: "Then it is Bob's turn.",
    });
    expect(words({ operator: 1, watching: [2] }, 1).next).toBe("Nobody else is waiting.");
  });

  it("tells queued viewers their place", () => {
    expect(words({ operator: 1, waiting: [2, 3] }, 3)).toEqual({
      headline: "You are number 2",
      next: "Ada is driving.",
    });
    expect(words({ operator: 1, waiting: [2] }, 2).headline).toBe("You are next");
  });

  it("tells observers what they could do", () => {
    expect(words({ operator: 1, watching: [2] }, 2)).toEqual({
      headline: "Ada is driving",
      next: "Nobody is waiting.",
    });
    expect(words({ operator: 1, waiting: [3], watching: [2] }, 2).next).toBe(
      "One person is waiting.",
    );
    expect(words({ operator: 1, waiting: [3, 4], watching: [2] }, 2).next).toBe(
      "2 people are waiting.",
    );
    expect(words({ watching: [2] }, 2)).toEqual({
      headline: "Nobody is driving",
      next: "The robot is free.",
    });
  });
});

it("tells viewers who cannot drive yet how to get a turn", () => {
  expect(joinWords(viewer(1))).toBe("Join the queue to drive.");
  expect(joinWords(null)).toBe("Join the queue to drive.");
  expect(joinWords(viewer(1, { role: "queued", place: 1 }))).toBe(
    "You drive when it is your turn.",
  );
});

it("tells disconnected viewers what is kept for them", () => {
  expect(lostWords(null, 3)).toEqual({ headline: "One moment…", next: "" });
  expect(lostWords(viewer(1), 3).next).toBe("");
  expect(lostWords(viewer(1, { role: "operator", place: 0 }), 3)).toEqual({
    headline: "Connection lost",
    next: "Come back within 3 s to keep your turn.",
  });
  expect(lostWords(viewer(1, { role: "queued", place: 2 }), 3).next).toBe(
    "Come back within 3 s to keep your place.",
  );
});

it("names what has a problem", () => {
  const now = room({});
  expect(problemWords(now)).toEqual([]);
  now.robot.connected = false;
  now.robot.bumpers = 2;
  now.video.problem = says("there is no camera");
  now.audio.problem = says("the microphone was unplugged");
  expect(problemWords(now)).toEqual([
    "The robot is not connected",
    "The robot's bumper is pressed",
    "Camera: there is no camera",
    "Microphone: the microphone was unplugged",
  ]);
});

describe("a stop", () => {
  const stop = pressedBy("Eve", { number: 3, viewer: 9 });
  const words = (options: Parameters<typeof room>[0], me: number, mayRelease = false) => {
    const now = room(options);
    const viewer = now.viewers.find((one) => one.id === me) ?? null;
    return stoppedWords(now, stop, viewer, mayRelease);
  };

  it("is shown with who pressed it", () => {
    expect(words({ watching: [1] }, 1).headline).toBe("Stopped by Eve");
    expect(words({ watching: [9] }, 9).headline).toBe("You stopped the robot");
  });

  it("does not say that nothing moves while somebody is aboard", () => {
    const now = { ...room({ operator: 1 }), aboard: aboard() };
    expect(stoppedWords(now, stop, null, true).next).toBe(
      "Only the person aboard may drive until you release it.",
    );
  });

  it("is shown with who can release it", () => {
    expect(words({ operator: 1 }, 1, true).next).toBe("Nothing moves until you release it.");
    expect(words({ operator: 2, watching: [1] }, 1).next).toBe(
      "Nothing moves until Bob or the host releases it.",
    );
    expect(words({ watching: [1] }, 1).next).toBe(
      "Nothing moves until the operator or the host releases it.",
    );
    const byHost = { ...stop, by_host: true };
    const now = room({ operator: 1 });
    expect(stoppedWords(now, byHost, now.viewers[0] ?? null, false).next).toBe(
      "Nothing moves until the host releases it.",
    );
  });
});

describe("the turn's clock", () => {
  const stands = (change: Partial<RoomState>) => {
    const now = room({ operator: 1 });
    return standingWords({ ...now, turn: { ...now.turn, stands_left_ms: 30_000 }, ...change });
  };

  it("is not mentioned while it runs", () => {
    expect(standingWords(room({ operator: 1 }))).toBeNull();
    expect(standingWords(null)).toBeNull();
  });

  it("has a reason shown while it is stopped", () => {
    const { host_settings, robot, video } = room({});
    expect(stands({ stop: pressedBy("Eve") })).toContain("while the robot is stopped.");
    expect(stands({ host_settings: { ...host_settings, blanked: true } })).toContain(
      "picture and sound off",
    );
    expect(stands({ robot: { ...robot, connected: false } })).toContain("does not answer");
    expect(stands({ aboard: aboard({ mode: "hand" }) })).toContain(
      "the person aboard has the robot.",
    );
    expect(stands({ aboard: aboard() })).toContain("nobody can drive");
    expect(stands({ video: { ...video, problem: says("unplugged") } })).toContain(
      "there is no picture",
    );
    expect(stands({})).toBe("The clock stands still while nobody can drive.");
  });
});

it("tells viewers who missed their call what became of their place", () => {
  expect(missedWords(null)).toBeNull();
  expect(missedWords("kept")).toContain("Your place is kept this once.");
  expect(missedWords("lost")).toContain("Join again.");
});

it("tells queued viewers and observers that the queue is paused", () => {
  const now = room({ operator: 2, waiting: [1], watching: [3] });
  now.host_settings.held = true;
  for (const id of [1, 3]) {
    const me = now.viewers.find((one) => one.id === id) ?? null;
    expect(turnWords(now, me).next).toContain("The queue is paused");
  }
});

it("keeps a right-to-left name from reordering the sentence", () => {
  expect(named("Ada")).toBe("Ada");
  expect(named("עדה")).toBe("\u2068עדה\u2069");
});

it("describes a connection to the host", () => {
  const line = { id: 1, address: "", invited: false, muted: false };
  const good = { ...line, round_trip_ms: 41.6, picture_ms: 80, rendition: "640x480" };
  expect(qualityWords(good)).toBe("42 ms there and back, picture 80 ms old, 640 × 480");
  const none = { ...line, round_trip_ms: null, picture_ms: null, rendition: null };
  expect(qualityWords(none)).toBe("no picture");
});

it("writes when something happens as people do", () => {
  const now = new Date(2026, 10, 22, 18, 0).getTime();
  const at = (day: number, hour: number) => new Date(2026, 10, day, hour, 30).getTime();
  expect(whenWords(at(22, 19), now, "en-GB")).toBe("today at 19:30");
  expect(whenWords(at(23, 9), now, "en-GB")).toBe("tomorrow at 9:30");
  expect(whenWords(at(25, 9), now, "en-GB")).toBe("on Wednesday at 9:30");
  expect(whenWords(new Date(2026, 11, 24, 9, 30).getTime(), now, "en-GB")).toBe(
    "on 24 December at 9:30",
  );
});
