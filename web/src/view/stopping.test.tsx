// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { beforeEach, describe, expect, it, vi } from "vitest";
import { hello, pressedBy, room } from "../testing/messages";
import { says } from "../words/said";
import {
  actions,
  body,
  button,
  drawsPage,
  input,
  key,
  open,
  pointer,
  show,
  state,
} from "./page.test.setup";
import { released } from "./pageWords";

drawsPage();

describe("Stop", () => {
  it("acts on touch, and not again when the touch ends", () => {
    show({ operator: 1 });
    pointer(button("Stop"), "pointerdown");
    expect(actions.stop).toHaveBeenCalledOnce();
    pointer(button("Stop"), "pointerup");
    button("Stop").dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 1 }));
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it.each(["Space", "Enter"])("acts at once on %s while it has the focus", (code) => {
    show({ watching: [1] });
    key(button("Stop"), "keydown", code);
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it("acts on a press by neither finger nor key", () => {
    show({ watching: [1] });
    button("Stop").click();
    expect(actions.stop).toHaveBeenCalledOnce();
  });

  it.each([
    ["watches", { operator: 2, watching: [1] }],
    ["waits", { operator: 2, waiting: [1] }],
    ["drives", { operator: 1 }],
  ])("is there for who %s, with or without a connection", (_, options) => {
    show(options);
    expect(button("Stop").disabled).toBe(false);
    act(() => {
      state.link.value = { is: "connecting", reason: null };
    });
    expect(button("Stop").disabled).toBe(false);
  });

  it("is only for the operator and the host if the server says so", () => {
    show({ operator: 2, watching: [1] });
    const on_loss = { ...hello().on_loss, stop_by: "operator" as const };
    act(() => {
      state.hello.value = hello({ viewer: 1, on_loss });
    });
    expect(button("Stop").disabled).toBe(true);
    act(() => {
      state.room.value = room({ operator: 1 });
    });
    expect(button("Stop").disabled).toBe(false);
    act(() => {
      state.room.value = room({ operator: 2, watching: [1] });
      state.hello.value = hello({ viewer: 1, on_loss, is_host: true });
    });
    expect(button("Stop").disabled).toBe(false);
  });
});

it("warns while it is not confirmed, and can be pressed again", () => {
  show({ operator: 2, watching: [1] });
  expect(queryByRole(body, "alert")).toBeNull();
  act(() => {
    state.isStopUnconfirmed.value = true;
  });
  expect(getByRole(body, "alert").textContent).toContain("Stop is not confirmed");
  expect(button("Stop").disabled).toBe(false);
  act(() => {
    state.isStopUnconfirmed.value = false;
  });
  expect(queryByRole(body, "alert")).toBeNull();
});

describe("a stop in force", () => {
  const stop = pressedBy("Cleo", { number: 7 });
  const release = () => queryByRole(body, "button", { name: "Hold to release" });

  beforeEach(() => {
    vi.useFakeTimers();
  });

  function wait(ms: number): void {
    act(() => {
      vi.advanceTimersByTime(ms);
    });
  }

  it("is shown to everybody, with who pressed it and who can release it", () => {
    show({ operator: 2, watching: [1], stop });
    const words = getByText(body, "Stopped by Cleo").parentElement;
    expect(words?.getAttribute("aria-live")).toBe("assertive");
    expect(words?.textContent).toContain("Nothing moves until Bob or the host releases it.");
    expect(release()).toBeNull();
    show({ operator: 2, watching: [1] });
    expect(queryByText(body, "Stopped by Cleo")).toBeNull();
  });

  it("removes the drive buttons, and returns them released", () => {
    show({ operator: 1 });
    pointer(button("Forward"), "pointerdown");
    show({ operator: 1, stop });
    expect(input.isHolding).toBe(false);
    expect(button("Forward").disabled).toBe(true);
    expect(button("Stop").disabled).toBe(false);
    show({ operator: 1 });
    expect(button("Forward").disabled).toBe(false);
    expect(input.isHolding).toBe(false);
  });

  it("is released by holding for 0.8 s, not by less", () => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    wait(700);
    pointer(button("Hold to release"), "pointerup");
    wait(1000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
    pointer(button("Hold to release"), "pointerdown");
    wait(900);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
    wait(2000);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
  });

  it("is released by Enter without a code, too, but not with Meta", () => {
    show({ operator: 1, stop });
    const hold = button("Hold to release");
    key(hold, "keydown", "Enter", { metaKey: true });
    wait(1000);
    key(hold, "keydown", "", { key: "Enter" });
    wait(700);
    key(hold, "keyup", "", { key: "Enter" });
    wait(1000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
    key(hold, "keydown", "", { key: "Enter" });
    wait(900);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
  });

  it.each(["pointercancel", "lostpointercapture", "blur"])("is not released after %s", (type) => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    pointer(button("Hold to release"), type);
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
  });

  it("keeps the hold when the page moves under the finger", () => {
    show({ operator: 1, stop });
    const capture = pointer(button("Hold to release"), "pointerdown", 7);
    expect(capture).toHaveBeenCalledExactlyOnceWith(7);
  });

  it("is not released when the window loses the focus meanwhile", () => {
    show({ operator: 1, stop });
    pointer(button("Hold to release"), "pointerdown");
    act(() => void window.dispatchEvent(new Event("blur")));
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
  });

  it("is released by holding Enter, and never by Space or a click", () => {
    show({ operator: 1, stop });
    key(button("Hold to release"), "keydown", "Space");
    wait(2000);
    key(button("Hold to release"), "keyup", "Space");
    button("Hold to release").click();
    wait(2000);
    expect(actions.releaseStop).not.toHaveBeenCalled();
    key(button("Hold to release"), "keydown", "Enter");
    wait(900);
    expect(actions.releaseStop).toHaveBeenCalledOnce();
  });

  it("is released by the host, too, who need not drive", () => {
    show({ operator: 2, watching: [1], stop });
    act(() => {
      state.hello.value = hello({ viewer: 1, is_host: true });
    });
    expect(release()).not.toBeNull();
  });

  it("asks the operator for a new press once it is released", () => {
    show({ operator: 1 });
    act(() => {
      state.isFreshlyReleased.value = true;
    });
    expect(getByText(body, released())).toBeTruthy();
    act(() => {
      state.driveReason.value = says("Slow: the link is late.");
    });
    expect(queryByText(body, released())).toBeNull();
    expect(getByText(body, "Slow: the link is late.")).toBeTruthy();
  });
});

describe("the rules", () => {
  it("are shown to everybody, and cannot be changed", () => {
    show({ watching: [1] });
    open("Safety");
    const panel = getByText(body, /150 ms/).closest("ul");
    expect(panel?.textContent).toContain("150 ms");
    expect(panel?.querySelector("input, select, button")).toBeNull();
  });
});
