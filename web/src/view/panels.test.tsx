// @vitest-environment dom
import { getByText, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { describe, expect, it } from "vitest";
import { DEFAULTS } from "../generated/defaults";
import { playout, room, served } from "../testing/messages";
import { body, button, drawsPage, show, state } from "./page.test.setup";

drawsPage();

describe("a panel", () => {
  const close = () => button("Close the panel");

  it("returns the focus to its tab when it is closed with a key", () => {
    for (const shut of [
      () => close().click(),
      () => close().dispatchEvent(new KeyboardEvent("keydown", { key: "Escape", bubbles: true })),
    ]) {
      act(() => button("Settings").click());
      close().focus();
      act(() => void shut());
      expect(document.activeElement).toBe(button("Settings"));
    }
  });

  it("leaves the keys to driving when it is closed by a pointer", () => {
    act(() => button("Settings").click());
    act(() => {
      close().dispatchEvent(new MouseEvent("click", { detail: 1, bubbles: true }));
    });
    expect(document.activeElement).not.toBe(button("Settings"));
  });
});

it("shows how many watch if they are too many to name", () => {
  show({ watching: [1] });
  expect(queryByText(body, /people watch/)).toBeNull();
  act(() => {
    state.watching.value = 12_345;
  });
  expect(getByText(body, "12,345 people watch.")).toBeTruthy();
});

it("shows how well it plays, what is sent and why", () => {
  show({ watching: [1] });
  act(() => {
    state.facts.value = {
      pictureMs: 46.2,
      pictureErrorMs: 2.4,
      soundMs: 80,
      skewMs: 33.8,
      roundTripMs: 12,
      jitterMs: 2,
      bufferMs: 30,
      arrivedFps: 25,
      fps: 25,
      pauses: { count: 0, longestMs: 0 },
      freezes: { count: 1, longestMs: 410 },
    };
    state.served.value = served();
    state.playout.value = playout();
    state.box.value = { width: 800, height: 300 };
  });
  const told = (name: string) => getByText(body, name).nextElementSibling?.textContent;
  expect(button(/^Delay/).textContent).toBe("Delay46 ms");
  act(() => button(/^Delay/).click());
  expect(told("Picture age")).toBe("46 ms ± 3");
  expect(told("Not included")).toContain("camera");
  act(() => {
    const host_settings = { ...DEFAULTS.HostSettings(), camera_delay_ms: 48 };
    state.room.value = { ...room({ watching: [1] }), host_settings };
  });
  expect(told("With camera and screen")).toBe("94 ms");
  expect(queryByText(body, "Not included")).toBeNull();
  expect(told("Sound age")).toBe("80 ms");
  expect(told("Skew")).toBe("sound 34 ms later");
  expect(told("Sound gaps, last minute")).toBe("none");
  expect(told("Freezes, last minute")).toBe("1, longest 410 ms");
  expect(told("Playback")).toBe("Smooth");
  expect(told("Picture shown")).toBe("400 × 300");
  expect(told("Picture sent")).toContain("640 × 480");
  expect(told("Sound sent")).toContain("20 ms packets");
  expect(told("Link")).toContain("2.4 Mbit/s");
  expect(getByText(body, "as large as asked for")).toBeTruthy();
  expect(getByText(body, "the picture follows the sound")).toBeTruthy();
});

it("never shows a negative delay, whatever the clocks' error", () => {
  show({ watching: [1] });
  act(() => {
    state.facts.value = { ...state.facts.value, pictureMs: -1.4 };
  });
  expect(button(/^Delay/).textContent).toBe("Delay0 ms");
});

it("does not mistake a page in a LiveKit room for the operator's", () => {
  show({ operator: 1 });
  expect(state.mayMove.value).toBe(true);
  act(() => {
    state.isInRoom.value = true;
  });
  expect(state.mayMove.value).toBe(false);
});
