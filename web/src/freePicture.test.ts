import { expect, it } from "vitest";
import { freePicture } from "./freePicture";
import { loadPreferences } from "./preferences";
import { createState } from "./state";
import { hello, room } from "./testing/messages";

/** A page in a window that is, or is not, a phone in landscape, and that can be turned. */
function opened(isAcross: boolean) {
  const across = Object.assign(new EventTarget(), { matches: isAcross });
  const state = createState(loadPreferences(null));
  const window = { matchMedia: () => across } as unknown as Window;
  freePicture(window, state, new AbortController().signal);
  const turn = () => {
    across.matches = !across.matches;
    across.dispatchEvent(new Event("change"));
  };
  return { state, turn };
}

it("closes panels over the picture on a phone in landscape, also when it is turned", () => {
  expect(opened(true).state.panel.value).toBeNull();
  const { state, turn } = opened(false);
  expect(state.panel.value).toBe("people");
  turn();
  expect(state.panel.value).toBeNull();
});

it("closes an open panel there when a turn begins, but not elsewhere", () => {
  for (const [isAcross, left] of [
    [true, null],
    [false, "settings"],
  ] as const) {
    const { state } = opened(isAcross);
    state.panel.value = "settings";
    state.link.value = { is: "connected" };
    state.hello.value = hello({ viewer: 1 });
    state.room.value = room({ operator: 1 });
    expect(state.panel.value).toBe(left);
  }
});
