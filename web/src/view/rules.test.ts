import { expect, it } from "vitest";
import { hello } from "../testing/messages";
import { lossSentences } from "./rules";

const all = (more: Parameters<typeof hello>[0] = {}, told: number | null = null) =>
  lossSentences(hello(more), told).join(" ");
const { on_loss } = hello();

it("state each of the server's numbers", () => {
  const own = {
    max_age_ms: 151,
    max_command_age_ms: 502,
    slow_picture_age_ms: 403,
    stop_picture_age_ms: 804,
    resume_within_ms: 905,
    lost_after_ms: 1006,
    max_stop_distance_m: 0.35,
    silence_ms: 126,
    robot_ttl_ms: 207,
  };
  const told = all({ on_loss: { ...on_loss, ...own } });
  for (const figure of Object.values(own)) expect(told).toContain(`${figure} m`);
});

it("admit if nobody knows whether the robot stops by itself", () => {
  expect(all({ on_loss: { ...on_loss, robot_ttl_ms: null } })).toContain("nobody knows");
  expect(all()).not.toContain("nobody knows");
});

it("trust the robot about its watchdog, not the host", () => {
  expect(all({}, 512)).toContain("the robot stops by itself after 512 ms");
  expect(all({}, 512)).not.toContain("200 ms");
  expect(all({ on_loss: { ...on_loss, robot_ttl_ms: null } }, 512)).not.toContain("nobody knows");
});

it("say plainly if the robot never stops by itself", () => {
  for (const silence_ms of [120, null]) {
    const told = all({ on_loss: { ...on_loss, silence_ms } }, 0);
    expect(told).toContain("it never stops by itself");
    expect(told).toContain("this robot drives on");
    expect(told).not.toContain(" 0 ms");
  }
});

it("promise no watchdog that this robot lacks", () => {
  const alone = all({ on_loss: { ...on_loss, silence_ms: null, robot_ttl_ms: null } });
  expect(alone).toContain("The server controls this robot directly");
  expect(alone).not.toContain("null");
});

it("state the highest speed in any direction", () => {
  const { robot } = hello();
  expect(all()).toContain("never faster than 0.6 m/s");
  expect(all({ robot: { ...robot, max_lateral_mps: 0.8 } })).toContain("never faster than 0.8 m/s");
});

it("state how long a lost turn is kept", () => {
  expect(all({ grace_s: 7 })).toContain("back within 7 s");
});

it("state whether this robot brakes gently", () => {
  expect(all({ on_loss: { ...on_loss, soft_braking: true } })).toContain("slows down gently");
  expect(all()).toContain("Whatever stops the robot stops it at once");
});

it("state who may press Stop", () => {
  expect(all()).toContain("Everybody who watches can press Stop");
  expect(all({ on_loss: { ...on_loss, stop_by: "operator" } })).toContain(
    "Only the operator and the host can press Stop",
  );
});

it("promise no emergency stop", () => {
  expect(all()).toContain("is not an emergency stop");
});
