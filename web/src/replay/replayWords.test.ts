import { beforeAll, expect, it } from "vitest";
import { DEFAULTS } from "../generated/defaults";
import type { Commanded, Reported, Steered } from "../messages";
import { loadSaid } from "../words/said";
import { clockWords, commandWords, partWords, reportedWords, steeredWords } from "./replayWords";

beforeAll(() => loadSaid());

it("writes a time within a part", () => {
  expect(clockWords(0)).toBe("0:00.0");
  expect(clockWords(65_390)).toBe("1:05.3");
  expect(clockWords(-5)).toBe("0:00.0");
});

it("describes the operator's command and what became of it", () => {
  const command = {
    held: true,
    linear: 0.5,
    angular: -1,
    axes: { pan: 1 },
    speed: "slow",
  } as unknown as Commanded;
  expect(commandWords(command)).toBe("forward 50 %, right 100 %, pan; slow");
  expect(commandWords({ ...command, held: false })).toBe("nothing is held");
  expect(commandWords({ ...command, lateral: -0.5 })).toBe(
    "forward 50 %, sideways right 50 %, right 100 %, pan; slow",
  );
  expect(commandWords(null)).toBe("no commands arrive");
  const steered = { linear_mps: 0, angular_rps: 0, reason: "too_old", limit: null } as Steered;
  expect(steeredWords(steered)).toBe(
    "standing still (the operator reads “Your commands do not arrive in time: your connection is slow.”)",
  );
  expect(steeredWords({ ...steered, reason: "pressed" })).toBe("standing still (Stop is pressed)");
  expect(steeredWords({ ...steered, linear_mps: 0.4, reason: null, limit: "long_delay" })).toBe(
    "0.40 m/s, 0.00 rad/s (the operator reads “Slow: your connection has a long delay.”)",
  );
  expect(steeredWords({ ...steered, lateral_mps: -0.2, reason: null })).toBe(
    "0.00 m/s, sideways -0.20 m/s, 0.00 rad/s",
  );
});

it("describes the robot's report, and its absence", () => {
  const reported = {
    ...DEFAULTS.Reported(),
    connected: true,
    problem: null,
    moving: null,
  } as Reported;
  expect(reportedWords(reported)).toBe("nothing");
  expect(reportedWords({ ...reported, moving: true, battery_v: 11.04 })).toBe(
    "its wheels turn, 11.0 V",
  );
  expect(reportedWords({ ...reported, connected: false })).toBe("not connected");
});

it("says why a part is kept", () => {
  const part = { name: "wax-1", began_wall_ms: 0, size_bytes: 8_000_000, kept: "fault" } as const;
  expect(partWords("en")(part)).toContain("8.0 MB, a fault");
});
