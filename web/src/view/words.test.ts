import { describe, expect, it } from "vitest";
import { room, viewer } from "../testing/messages";
import {
  batteryWords,
  connectionWords,
  inOrder,
  joinWords,
  lostWords,
  placeWords,
  problemWords,
  stoppedWords,
  turnWords,
  waitWords,
} from "./words";

it("says how the connection is, and when and why it is tried again", () => {
  expect(connectionWords({ is: "connected" }, 0)).toBe("Connected");
  const silent = { is: "silent", sinceMs: 5000 } as const;
  expect(connectionWords(silent, 5700)).toBe("No answer for 1 s");
  expect(connectionWords(silent, 7999)).toBe("No answer for 2 s");
  expect(connectionWords({ is: "connecting", reason: null }, 0)).toBe("Connecting…");
  const waiting = { is: "waiting", retryAtMs: 5000, reason: "The server is full." } as const;
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
  it("says who drives, waits and watches", () => {
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

it("lists who drives, then who waits by place, then who watches by coming", () => {
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

  it("tells who waits their place and an honest wait", () => {
    expect(words({ operator: 1, waiting: [2, 3] }, 3)).toEqual({
      headline: "You are number 2 in the queue, about 2 min",
      next: "Ada is driving.",
    });
    expect(words({ operator: 1, waiting: [2] }, 2).headline).toBe("You are next, about 30 s");
  });

  it("tells who watches what they could do", () => {
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

it("tells whoever cannot drive yet how to come to it", () => {
  expect(joinWords(viewer(1))).toBe("Join the queue to drive.");
  expect(joinWords(null)).toBe("Join the queue to drive.");
  expect(joinWords(viewer(1, { role: "queued", place: 1 }))).toBe(
    "You drive when it is your turn.",
  );
});

it("tells whoever is cut off what is kept for them", () => {
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
  now.video.problem = "there is no camera";
  now.audio.problem = "the microphone was unplugged";
  expect(problemWords(now)).toEqual([
    "Robot: it is not connected",
    "Robot: a bumper is pressed",
    "Camera: there is no camera",
    "Microphone: the microphone was unplugged",
  ]);
});

describe("a stop", () => {
  const stop = { number: 3, by: "Eve" };
  const words = (options: Parameters<typeof room>[0], me: number, mayRelease = false) => {
    const now = room(options);
    const viewer = now.viewers.find((one) => one.id === me) ?? null;
    return stoppedWords(now, stop, viewer, mayRelease);
  };

  it("is told with who pressed it", () => {
    expect(words({ watching: [1] }, 1).headline).toBe("Stopped by Eve");
  });

  it("is told with who ends it", () => {
    expect(words({ operator: 1 }, 1, true).next).toBe("Nothing moves until you release it.");
    expect(words({ operator: 2, watching: [1] }, 1).next).toBe(
      "Nothing moves until Bob or the host releases it.",
    );
    expect(words({ watching: [1] }, 1).next).toBe(
      "Nothing moves until the operator or the host releases it.",
    );
  });
});

it("tells of the battery what the robot tells", () => {
  const { robot } = room({});
  expect(batteryWords(robot)).toBe(null);
  expect(batteryWords({ ...robot, battery_v: 7.4 })).toBe("7.4 V");
  expect(batteryWords({ ...robot, battery_v: 12, battery_fraction: 0.615 })).toBe("62 %, 12.0 V");
});
