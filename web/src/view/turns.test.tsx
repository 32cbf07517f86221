// @vitest-environment dom
import { getAllByText, getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { describe, expect, it, vi } from "vitest";
import { DEFAULTS } from "../generated/defaults";
import type { Tape } from "../messages";
import { aboard, hello, room, served } from "../testing/messages";
import { says } from "../words/said";
import { Hours } from "./EndedPage";
import { actions, body, button, drawsPage, show, state } from "./page.test.setup";
import { blanked, notInvited } from "./pageWords";

drawsPage();

describe("a person aboard", () => {
  const driving = "The person aboard is driving: advise them until they let go.";
  function sits(
    more: Parameters<typeof aboard>[0],
    asked: "left" | null = null,
    operator = 2,
  ): void {
    const now = operator === 1 ? { operator } : { operator, watching: [1] };
    show(now);
    act(() => {
      state.room.value = { ...room(now), aboard: aboard(more) };
      state.request.value = asked && { asked };
    });
  }

  it("is not mentioned while an operator may drive", () => {
    sits({});
    expect(body.querySelector(".banners")?.textContent).toBe("");
  });

  it("drives, and everybody sees why nobody else can", () => {
    sits({ mode: "hand", reason: says(driving) });
    expect(getByText(body, driving)).toBeTruthy();
  });

  it("drives, which the operator sees only beside the controls", () => {
    sits({ mode: "hand", reason: says(driving) }, null, 1);
    act(() => {
      state.driveReason.value = says(driving);
    });
    expect(getByText(body, driving).closest(".banners")).toBeNull();
  });

  it("asks, which is read out at once", () => {
    sits({ asked: "left", asks: 1 }, "left");
    expect(getByRole(body, "alert").textContent).toBe("From aboard: To the left, please.");
  });

  it("has a hand control that does not answer, shown once as the robot's problem", () => {
    sits({ mode: "lost", reason: says("The hand control of the person aboard does not answer") });
    expect(body.querySelector(".banners")?.textContent).toBe("");
  });
});

describe("a call", () => {
  function call(viewer = 1): void {
    show({ operator: 2, waiting: [1] });
    act(() => {
      const now = room({ operator: 2, waiting: [1] });
      state.room.value = { ...now, call: { viewer, until_server_ms: 28_000 } };
    });
  }
  const card = () => queryByRole(body, "alertdialog");

  it("asks the next viewer, with the time left, and changes the title", () => {
    call();
    expect(card()?.textContent).toContain("Your turn is next. Are you ready?");
    expect(card()?.textContent).toContain("10 s left");
    expect(document.title).toContain("Are you ready?");
    show({ operator: 1 });
    expect(card()).toBeNull();
    expect(document.title).toContain("You are driving");
  });

  it("changes the tab's icon, but loads none over a thin link", () => {
    document.head.innerHTML = '<link rel="icon" href="icon.svg">';
    const icon = () => document.querySelector("link")?.getAttribute("href");
    call();
    expect(icon()).toBe("icon-wanted.svg");
    act(() => {
      state.served.value = served({ link_bps: 28_000 });
    });
    expect(icon()).toBe("icon.svg");
  });

  it("vibrates a phone when it comes, and again when the turn begins", () => {
    const vibrate = vi.fn(() => true);
    Object.defineProperty(navigator, "vibrate", { value: vibrate, configurable: true });
    call();
    expect(vibrate).toHaveBeenCalledExactlyOnceWith([200, 100, 200]);
    act(() => {
      state.serverMs.value = 19_000;
    });
    expect(vibrate).toHaveBeenCalledOnce();
    show({ operator: 1 });
    expect(vibrate).toHaveBeenCalledTimes(2);
    Reflect.deleteProperty(navigator, "vibrate");
  });

  it("takes the focus from text, but not from a control", () => {
    const turn = getByRole(body, "region", { name: "Turn" });
    turn.tabIndex = -1;
    turn.focus();
    call();
    expect(document.activeElement).toBe(button("I am ready"));
    show({ operator: 1 });
    button("Settings").focus();
    call();
    expect(document.activeElement).toBe(button("Settings"));
  });

  it("is shown to nobody else", () => {
    call(3);
    expect(card()).toBeNull();
  });

  it("is answered by a touch anywhere on it, once", () => {
    call();
    act(() => card()?.click());
    expect(actions.answerCall).toHaveBeenCalledOnce();
  });

  it("is answered by its button, once, and by any key on it but Tab", () => {
    call();
    expect(document.activeElement).toBe(button("I am ready"));
    act(() => button("I am ready").click());
    expect(actions.answerCall).toHaveBeenCalledOnce();
    button("I am ready").dispatchEvent(new KeyboardEvent("keydown", { key: "Tab" }));
    expect(actions.answerCall).toHaveBeenCalledOnce();
    button("I am ready").dispatchEvent(new KeyboardEvent("keydown", { key: "x" }));
    expect(actions.answerCall).toHaveBeenCalledTimes(2);
  });

  it("does not take the focus from a text field", () => {
    show({ operator: 2, waiting: [1] });
    const field = getByRole(body, "textbox", { name: "Your name" });
    field.focus();
    call();
    expect(document.activeElement).toBe(field);
  });

  it("that was missed is reported", () => {
    show({ operator: 2, waiting: [1] });
    act(() => {
      state.missedCall.value = "kept";
    });
    expect(getByText(body, /Your place is kept this once/)).toBeTruthy();
  });
});

describe("a turn that is over", () => {
  function isOver(tape: Partial<Tape>): void {
    show({ watching: [1] });
    act(() => {
      const recorded = { ...DEFAULTS.Tape(), running: true, why: says("It is recorded."), ...tape };
      state.room.value = { ...room({ watching: [1] }), tape: recorded };
      state.drivenTurn.value = 4;
    });
  }
  const name = "Do not use my recording";

  it("can be disowned while it is recorded for a purpose", () => {
    isOver({ can_disown: true });
    act(() => button(name).click());
    expect(actions.disown).toHaveBeenCalledOnce();
    act(() => {
      state.drivenTurn.value = null;
    });
    expect(queryByRole(body, "button", { name })).toBeNull();
  });

  it("cannot be disowned where the recording has no such purpose", () => {
    isOver({});
    expect(queryByRole(body, "button", { name })).toBeNull();
  });
});

describe("a viewer who may not stay, hear or drive", () => {
  it("sees why, and when the robot opens, and can retry", async () => {
    await Hours.load();
    vi.setSystemTime(new Date(2026, 10, 26, 12));
    show({ watching: [1] });
    act(() => {
      state.ended.value = {
        type: "ended",
        text: says("The robot is closed."),
        openings: [0, 1].map((day) => ({
          opens_wall_ms: new Date(2026, 10, 27 + day, 18).getTime(),
          closes_wall_ms: new Date(2026, 10, 27 + day, 21 + 3 * day).getTime(),
        })),
      };
    });
    expect(getByRole(body, "heading", { name: "The robot is closed." })).toBeTruthy();
    expect(getByText(body, /The robot opens tomorrow at/)).toBeTruthy();
    const zone = Intl.DateTimeFormat().resolvedOptions().timeZone;
    const hours = getByRole(body, "list", { name: new RegExp(`in your time \\(${zone}\\)`) });
    expect([...hours.children].map((one) => one.textContent?.replaceAll("\u202f", " "))).toEqual([
      "Friday 6:00 PM – 9:00 PM",
      "Saturday 6:00 PM – Sunday 12:00 AM",
    ]);
    // Relative, since a proxy may serve the page below a path.
    const calendar = getByRole(body, "link", { name: "Add to my calendar" });
    expect(calendar.getAttribute("href")).toBe("open.ics");
    expect(queryByRole(body, "button", { name: "Stop" })).toBeNull();
    act(() => button("Try again").click());
    expect(actions.comeBack).toHaveBeenCalledOnce();
  });

  it("sees what is wrong with the link that they opened, until dismissed", () => {
    show({ watching: [1] });
    act(() => {
      state.entryProblem.value = says("This invitation is used up; ask the host for a new one.");
    });
    expect(getByText(body, /used up/)).toBeTruthy();
    act(() => button("OK").click());
    expect(queryByText(body, /used up/)).toBeNull();
  });

  it("sees why it takes a while before the first connection", () => {
    act(() => {
      state.link.value = {
        is: "waiting",
        retryAtMs: 5000,
        reason: says("All 100 places are taken."),
      };
    });
    expect(getByText(body, "All 100 places are taken.")).toBeTruthy();
    expect(getByText(body, "This page tries again by itself.")).toBeTruthy();
  });

  it("is offered neither queue nor sound if those are by invitation", () => {
    show({ operator: 2, watching: [1] });
    act(() => {
      state.hello.value = hello({ viewer: 1, may_queue: false, may_hear: false });
    });
    expect(queryByRole(body, "button", { name: "Join the queue" })).toBeNull();
    expect(queryByRole(body, "switch", { name: "Sound" })).toBeNull();
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
    expect(getAllByText(body, notInvited()).length).toBeGreaterThan(0);
  });

  it("sees a card instead of a picture that the host has switched off", () => {
    show({ watching: [1] });
    act(() => {
      const now = room({ watching: [1] });
      now.host_settings.blanked = true;
      state.room.value = now;
    });
    expect(getByText(body, blanked())).toBeTruthy();
    expect(body.querySelector("video")?.classList.contains("is-off")).toBe(true);
  });
});

describe("the queue", () => {
  it("keeps a name while it is typed, whatever happens in the room", () => {
    show({ watching: [1] });
    const field = getByRole(body, "textbox", { name: "Your name" }) as HTMLInputElement;
    field.value = "Ad";
    act(() => void field.dispatchEvent(new Event("input", { bubbles: true })));
    show({ operator: 2, watching: [1] });
    expect(field.value).toBe("Ad");
    field.value = "Ada";
    act(() => void field.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setName).toHaveBeenCalledWith("Ada");
  });

  it("asks those who drive or wait what they are going to do, where the host wants it", () => {
    const field = () => queryByRole(body, "textbox", { name: "Your task" });
    const asks = (options: Parameters<typeof room>[0]) => {
      show(options);
      act(() => {
        const tape = { ...DEFAULTS.Tape(), running: true, why: says("."), asks_task: true };
        state.room.value = { ...room(options), tape };
      });
    };
    show({ operator: 1 });
    expect(field()).toBeNull();
    asks({ operator: 2, watching: [1] });
    expect(field()).toBeNull();
    asks({ operator: 1 });
    const shown = field() as HTMLInputElement;
    shown.value = "to the red post";
    act(() => void shown.dispatchEvent(new Event("change", { bubbles: true })));
    expect(actions.setTask).toHaveBeenCalledWith("to the red post");
    act(() => {
      state.task.value = "to the red post";
    });
    expect(field()).toBeNull();
  });

  it("lists everybody in order and marks the user", () => {
    show({ operator: 2, waiting: [1], watching: [3] });
    const lines = [...getByRole(body, "list", { name: "Queue" }).children];
    expect(lines.map((line) => line.textContent)).toEqual([
      "Bob driving",
      "Ada (you) next, about 30 s",
      "Cleo watching",
    ]);
  });

  it("shows a name as text", () => {
    show({ watching: [1] });
    act(() => {
      const now = room({ watching: [1] });
      for (const viewer of now.viewers) viewer.name = "<img src=x>";
      state.room.value = now;
    });
    expect(getByText(body, "<img src=x>")).toBeTruthy();
    expect(body.querySelector("img")).toBeNull();
  });

  it("shows the estimated wait, which is not read out by itself", () => {
    show({ operator: 2, waiting: [1] });
    expect(getByRole(body, "timer", { name: "Until your turn" }).textContent).toBe("about 30 s");
    expect(button("Leave the queue")).toBeTruthy();
  });

  it("offers a notification to a queued viewer if the browser has them", () => {
    const offer = () => queryByRole(body, "switch", { name: "Tell me when it is my turn" });
    show({ operator: 2, waiting: [1] });
    expect(offer()).toBeNull();
    vi.stubGlobal("Notification", { permission: "default" });
    vi.stubGlobal("navigator", { serviceWorker: {} });
    show({ operator: 2, watching: [1] });
    expect(offer()).toBeNull();
    show({ operator: 2, waiting: [1] });
    act(() => offer()?.click());
    expect(actions.tellMe).toHaveBeenCalledWith(true);
  });

  it("is joined and left by a click, but not both by a double-click", () => {
    show({ watching: [1] });
    button("Join the queue").click();
    expect(actions.join).toHaveBeenCalledOnce();
    show({ operator: 1 });
    const leave = button("End my turn");
    leave.dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 2 }));
    expect(actions.leave).not.toHaveBeenCalled();
    leave.dispatchEvent(new MouseEvent("click", { bubbles: true, detail: 1 }));
    expect(actions.leave).toHaveBeenCalledOnce();
  });
});
