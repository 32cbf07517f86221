// @vitest-environment dom
import { act } from "preact/test-utils";
import { expect, it } from "vitest";
import { loadPreferences } from "../preferences";
import { createState } from "../state";
import { draw } from "../testing/draw";
import { hello, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { LossPanel } from "./LossPanel";

it("follows the robot's report of its watchdog", () => {
  const state = createState(loadPreferences(null));
  state.hello.value = hello();
  const tells = (ttl_ms: number | null) =>
    act(() => {
      const now = room({});
      state.room.value = { ...now, robot: { ...now.robot, ttl_ms } };
    });
  draw(testSession(state), <LossPanel />);
  const text = () => document.body.textContent;
  expect(text()).toContain("stops by itself after 200 ms");
  tells(512);
  expect(text()).toContain("stops by itself after 512 ms");
  tells(0);
  expect(text()).toContain("it never stops by itself");
  tells(null);
  expect(text()).toContain("stops by itself after 200 ms");
});
