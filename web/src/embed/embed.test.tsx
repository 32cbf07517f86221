// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { render } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import { viewOf } from "../openView";
import { undraw } from "../testing/draw";
import { hello, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { says } from "../words/said";
import { Embed } from "./Embed";

const { body, documentElement: root } = document;
let session: Session;

beforeEach(() => {
  vi.stubGlobal("location", new URL("https://robot.example.org/rover/?view=embed#x"));
  root.dataset.view = "embed";
  session = testSession();
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 9 });
  act(() => render(<Embed session={session} />, body));
});

afterEach(() => {
  undraw();
  delete root.dataset.view;
});

function show(options: Parameters<typeof room>[0]): void {
  act(() => {
    session.state.room.value = room(options);
  });
}

it("is chosen by the server, whatever the address asks for", async () => {
  const load = viewOf("?view=big-screen");
  expect(await load?.()).toHaveProperty("View", Embed);
  delete root.dataset.view;
  expect(viewOf("?view=embed")).toBeNull();
});

it("shows who drives and how many wait", () => {
  show({ operator: 1, waiting: [2, 3], watching: [9] });
  expect(getByText(body, "Ada is driving")).toBeTruthy();
  expect(getByText(body, "2 people wait")).toBeTruthy();
  show({ watching: [9] });
  expect(getByText(body, "Nobody is driving: the robot is free")).toBeTruthy();
  expect(getByText(body, "Nobody is waiting")).toBeTruthy();
});

it("has a sound button, and no other control but the link to the page", () => {
  show({ operator: 9, watching: [] });
  const sound = getByRole(body, "button", { name: "Turn sound on" });
  expect([...body.querySelectorAll("button, input, select")]).toEqual([sound]);
  expect(session.actions.setSound).not.toHaveBeenCalled();
  act(() => sound.click());
  expect(session.actions.setSound).toHaveBeenCalledExactlyOnceWith(true);
  act(() => {
    session.state.hello.value = hello({ has_microphone: false });
  });
  expect(queryByRole(body, "button")).toBeNull();
});

it("opens the page in a new tab, without access to this one", () => {
  const link = getByRole<HTMLAnchorElement>(body, "link", { name: "Drive this robot" });
  expect(link.getAttribute("href")).toBe("https://robot.example.org/rover/");
  expect([link.target, link.rel]).toEqual(["_blank", "noopener"]);
  act(() => {
    session.state.hello.value = hello({ may_queue: false });
  });
  expect(getByRole(body, "link", { name: "Open the robot’s page" })).toBe(link);
});

it("shows the address to copy once the link is pressed, as a site may allow no tab", () => {
  const link = getByRole(body, "link");
  link.addEventListener("click", (event) => event.preventDefault());
  act(() => link.click());
  expect(link.textContent).toBe("https://robot.example.org/rover/");
});

it("says why there is no picture, in the server's words if it has any", () => {
  const problem = () => getByRole(body, "status").textContent;
  expect(problem()).toBe("");
  act(() => {
    const reason = says("Too many people watch on other sites now.");
    session.state.link.value = { is: "waiting", retryAtMs: 0, reason };
  });
  expect(problem()).toBe("Too many people watch on other sites now.");
  expect(queryByText(body, /driving/)).toBeNull();
  act(() => {
    session.state.ended.value = { type: "ended", text: says("Closed for today."), openings: [] };
  });
  expect(problem()).toBe("Closed for today.");
});
