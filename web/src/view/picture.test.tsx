// @vitest-environment dom
import { getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { beforeEach, describe, expect, it, vi } from "vitest";
import type { Tape } from "../messages";
import { hello, playout, room, served } from "../testing/messages";
import { says } from "../words/said";
import { actions, body, button, drawsPage, hears, open, show, state } from "./page.test.setup";
import { PathArc } from "./Views";

drawsPage();

it("loads the predicted path once there is a picture to draw it on", async () => {
  const camera = { height_m: 0.3, tilt_deg: 30, fov_deg: 75, axis_row: 0.5 };
  const path = () => body.querySelector(".path-arc");
  const sees = (pictureMs: number | null) =>
    act(async () => {
      state.facts.value = { ...state.facts.value, pictureMs };
      await PathArc.load();
    });
  show({ watching: [1] });
  await sees(80);
  expect(path()).toBeNull();
  act(() => {
    const mine = hello({ viewer: 1 });
    state.hello.value = { ...mine, robot: { ...mine.robot, camera } };
  });
  expect(path()).not.toBeNull();
  await sees(null);
  expect(path()).toBeNull();
});

it("gives its box the picture's shape, so that no bars stand beside it", () => {
  const video = body.querySelector("video");
  const shape = (element: Element | null | undefined, name: string) =>
    Number((element as HTMLElement).style.getPropertyValue(name) || Number.NaN);
  const shown = (videoWidth: number, videoHeight: number) => {
    for (const [name, value] of Object.entries({ videoWidth, videoHeight }))
      Object.defineProperty(video, name, { value, configurable: true });
    video?.dispatchEvent(new Event("resize"));
    const box = body.querySelector(".picture");
    return [shape(box, "--aspect"), shape(box?.parentElement, "--shape")];
  };
  expect(shown(0, 0)).toEqual([Number.NaN, Number.NaN]);
  expect(shown(1280, 720)).toEqual([16 / 9, 16 / 9]);
  expect(shown(480, 640)).toEqual([3 / 4, 3 / 4]);
  expect(shown(0, 0)).toEqual([3 / 4, 3 / 4]);
});

describe("sound and picture", () => {
  it("offers sound until the user has decided", () => {
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeTruthy();
    button("Turn sound on").click();
    expect(actions.start).toHaveBeenCalledOnce();
    act(() => {
      state.isStartOffered.value = false;
    });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
  });

  it("offers no sound if there is nothing to hear", () => {
    show({ watching: [1] });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeTruthy();
    act(() => {
      state.hello.value = hello({ viewer: 1, has_microphone: false });
    });
    expect(queryByRole(body, "button", { name: "Turn sound on" })).toBeNull();
    expect(queryByRole(body, "switch", { name: "Sound" })).toBeNull();
    open("Settings");
    expect(body.textContent).toContain("This robot has no microphone.");
  });

  it("switches each separately", () => {
    show({ watching: [1] });
    const sound = getByRole(body, "switch", { name: "Sound" });
    expect(sound.getAttribute("aria-checked")).toBe("false");
    sound.click();
    expect(actions.setSound).toHaveBeenCalledWith(true);
    open("Settings");
    const picture = getByRole(body, "switch", { name: "Picture" });
    expect(picture.getAttribute("aria-checked")).toBe("true");
    picture.click();
    expect(actions.setPicture).toHaveBeenCalledWith(false);
  });

  function choose(name: string, value: string): void {
    const select = getByRole<HTMLSelectElement>(body, "combobox", { name });
    act(() => {
      select.value = value;
      select.dispatchEvent(new Event("change", { bubbles: true }));
    });
  }

  it("limits the picture's size", () => {
    show({ watching: [1] });
    open("Settings");
    const select = getByRole(body, "combobox", { name: "Picture size" });
    const options = [...select.children].map((one) => one.textContent);
    expect(options).toEqual(["Largest, 640 × 480", "Up to 320 × 240"]);
    choose("Picture size", "320x240");
    expect(actions.setSize).toHaveBeenCalledWith("320x240");
  });

  it("offers no choice if one policy holds for everybody", () => {
    show({ watching: [1] });
    open("Settings");
    act(() => {
      state.playout.value = playout({ policy: "thesis" });
    });
    expect(getByRole(body, "combobox", { name: "Picture size" })).toBeTruthy();
    expect(queryByRole(body, "radio", { name: "Immediate" })).toBeNull();
  });

  it("says, without an alarm, that the link cannot carry both in step while that lasts", () => {
    const words = "Your connection is slow: picture and sound play as soon as they arrive.";
    show({ watching: [1] });
    act(() => {
      state.served.value = served({ in_step: false });
    });
    expect(getByText(body, words)).toBeTruthy();
    act(() => {
      state.served.value = served();
    });
    expect(queryByText(body, words)).toBeNull();
  });

  it("says, without an alarm, that the picture is off", () => {
    show({ watching: [1] });
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
    });
    expect(getByText(body, "The picture is off.")).toBeTruthy();
  });

  it("shows what is wrong with robot, camera and microphone", () => {
    show({ watching: [1] });
    act(() => {
      state.room.value = {
        ...room({ watching: [1] }),
        video: { ...room({}).video, problem: says("it was unplugged") },
      };
    });
    expect(getByText(body, "Camera: it was unplugged")).toBeTruthy();
  });

  it("says why nobody can drive by a picture of unknown age, and shows no age", () => {
    show({ watching: [1] });
    act(() => {
      const undated = { code: "drive.undated", values: {} };
      state.room.value = { ...room({ watching: [1] }), video: { problem: null, undated } };
      state.facts.value = { ...state.facts.value, pictureMs: 5 };
    });
    expect(getByText(body, /nobody knows how old it is/)).toBeTruthy();
    expect(button(/^Delay/).textContent).toBe("Delay–");
  });
});

describe("the level of the sound", () => {
  beforeEach(() => vi.useFakeTimers());

  const shown = async (channels: number, found: number[]) => {
    hears(found);
    show({ watching: [1] });
    act(() => {
      state.served.value = served({ sound_channels: channels });
      state.isSoundOn.value = true;
    });
    await act(async () => {
      await vi.advanceTimersByTimeAsync(250);
    });
    return [...body.querySelectorAll<HTMLMeterElement>(".sound-meter:not(.is-off) meter")].map(
      (one) => [one.getAttribute("aria-label"), one.value],
    );
  };

  it("is shown per ear in stereo", async () => {
    expect(await shown(2, [0.5, 0.25])).toEqual([
      ["Sound level, left", 0.5],
      ["Sound level, right", 0.25],
    ]);
  });

  it("is one for mono sound, or if the player does not distinguish the ears", async () => {
    expect(await shown(1, [0.5, 0.5])).toEqual([["Sound level", 0.5]]);
    expect(await shown(2, [0.25])).toEqual([["Sound level", 0.25]]);
  });

  it("is not shown if it is unknown or the sound is off", async () => {
    expect(await shown(2, [])).toEqual([]);
    await shown(2, [0.5, 0.5]);
    act(() => {
      state.isSoundOn.value = false;
    });
    expect(body.querySelector(".sound-meter:not(.is-off)")).toBeNull();
  });
});

it("reports a slow connection, but not as a problem", () => {
  show({ watching: [1] });
  const slow = /^Your connection is slow/;
  expect(queryByText(body, slow)).toBeNull();
  act(() => {
    state.served.value = served({ in_step: false });
  });
  expect(getByText(body, slow).closest("[aria-live]")).toBeTruthy();
  expect(getByRole(body, "list", { name: "Problems" }).textContent).toBe("");
});

describe("a picture that is not live", () => {
  const NOT_LIVE = "Not live: the server is not answering.";
  const isGrey = () =>
    getByRole(body, "region", { name: "Picture" }).classList.contains("is-greyed");

  it("is grey while the server does not answer, with the time", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 46 };
    });
    expect(isGrey()).toBe(false);
    act(() => {
      state.link.value = { is: "silent", sinceMs: 1000 };
      state.pageMs.value = 3200;
    });
    expect(isGrey()).toBe(true);
    expect(getByRole(body, "status").textContent).toBe("No answer for 2 s");
    expect(getByText(body, NOT_LIVE)).toBeTruthy();
    expect(button(/^Delay/).textContent).toBe("Delay–");
    act(() => {
      state.link.value = { is: "connected" };
    });
    expect(isGrey()).toBe(false);
    expect(queryByText(body, NOT_LIVE)).toBeNull();
  });

  it("is grey when it has been frozen for long on a working link", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
    });
    expect(isGrey()).toBe(true);
    expect(getByText(body, "The picture is 1700 ms old.")).toBeTruthy();
  });

  it("is not read out again with each new age or each second without an answer", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
    });
    expect(getByText(body, "The picture is 1700 ms old.").getAttribute("aria-hidden")).toBe("true");
    expect(getByText(body, "The picture is not live.").closest("[aria-live=polite]")).toBeTruthy();
    act(() => {
      state.link.value = { is: "waiting", retryAtMs: 3000, reason: says("The server is gone.") };
    });
    expect(getByRole(body, "status").getAttribute("aria-live")).toBe("off");
    const told = getByText(body, "Reconnecting… The server is gone.");
    expect(told.getAttribute("aria-live")).toBe("polite");
    act(() => {
      state.link.value = { is: "connecting", reason: says("The server is gone.") };
    });
    expect(getByRole(body, "status").getAttribute("aria-live")).toBe("off");
    expect(told.textContent).toBe("Reconnecting… The server is gone.");
  });

  it("is mentioned only once", () => {
    show({ watching: [1] });
    act(() => {
      state.facts.value = { ...state.facts.value, pictureMs: 1700 };
      state.link.value = { is: "silent", sinceMs: 0 };
    });
    expect(getByText(body, NOT_LIVE)).toBeTruthy();
    expect(queryByText(body, "The picture is 1700 ms old.")).toBeNull();
  });

  it("is not mentioned if the picture is off", () => {
    show({ watching: [1] });
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
      state.link.value = { is: "silent", sinceMs: 0 };
    });
    expect(queryByText(body, NOT_LIVE)).toBeNull();
    expect(getByRole(body, "status").textContent).toContain("No answer");
  });
});

describe("cameras other than the driving view", () => {
  const TWO = [
    { name: "Door", axes: [] },
    { name: "Above", axes: ["pan"] },
  ];
  const fine = { problem: null };

  function showTwo(more: { driving?: boolean; large?: number | null } = {}): void {
    show(more.driving ? { operator: 1 } : { watching: [1] }, ["pan", "arm"]);
    act(() => {
      state.hello.value = { ...(state.hello.value ?? hello()), cameras: TWO };
      state.room.value = { ...(state.room.value ?? room({})), cameras: [fine, fine] };
      state.served.value = served({ cameras: ["small", "small"] });
      state.large.value = more.large ?? null;
    });
  }

  it("are small, and a tap makes one large", () => {
    showTwo();
    button("Make Above large").click();
    expect(actions.enlarge).toHaveBeenCalledWith(1);
    expect(queryByRole(body, "button", { name: "Make Driving view large" })).toBeNull();
  });

  it("leave the driving view visible, with its name, beside a large one", () => {
    showTwo({ driving: true, large: 0 });
    const views = body.querySelectorAll(".view");
    expect([...views].map((one) => one.querySelector("video") !== null)).toEqual([
      true,
      true,
      true,
    ]);
    expect(views[0]?.classList.contains("is-driving-view")).toBe(true);
    expect(body.querySelector(".views")?.classList.contains("is-watched")).toBe(true);
    expect(views[1]?.classList.contains("is-large")).toBe(true);
    button("Make Driving view large").click();
    expect(actions.enlarge).toHaveBeenCalledWith(null);
  });

  it("say why they show nothing: the camera's own words, or the connection", () => {
    showTwo();
    act(() => {
      const failing = [{ problem: says("Door: The plug is out.") }, fine];
      state.room.value = { ...room({ watching: [1] }), cameras: failing };
      state.served.value = served({ cameras: ["small", null] });
    });
    expect(getByText(body, "Door: The plug is out.")).toBeTruthy();
    expect(getByText(body, "Your connection carries no more.")).toBeTruthy();
    expect(body.querySelectorAll(".view.is-old")).toHaveLength(2);
  });

  it("turn grey once they show nothing new", () => {
    showTwo();
    act(() => {
      state.staleCameras.value = new Set([1]);
    });
    const old = [...body.querySelectorAll(".view")].map((one) => one.classList.contains("is-old"));
    expect(old).toEqual([false, false, true]);
  });

  it("are hidden with the picture, and while the host has blanked it", () => {
    showTwo();
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
    });
    expect(body.querySelectorAll(".view")).toHaveLength(1);
  });

  it("can be hidden, except a large one", () => {
    showTwo({ large: 1 });
    open("Settings");
    getByRole(body, "switch", { name: "Other cameras" }).click();
    expect(actions.setCameras).toHaveBeenCalledWith(false);
    act(() => {
      state.preferences.value = { ...state.preferences.value, cameras: false };
    });
    const hidden = [...body.querySelectorAll<HTMLElement>(".view")].map((one) => one.hidden);
    expect(hidden).toEqual([false, true, false]);
  });

  it("name the axes that turn them", () => {
    showTwo({ driving: true });
    expect(getByRole(body, "slider", { name: "pan of Above" })).toBeTruthy();
    expect(getByRole(body, "slider", { name: "arm" })).toBeTruthy();
  });

  it("are not offered if there are none", () => {
    show({ watching: [1] });
    open("Settings");
    expect(queryByRole(body, "switch", { name: "Other cameras" })).toBeNull();
  });
});

it("names other sites' pages while the server is full", () => {
  const url = "https://watch.example.org/robot";
  act(() => {
    state.links.value = [url];
    state.link.value = {
      is: "waiting",
      retryAtMs: 5000,
      reason: says("All places to watch are taken."),
    };
  });
  expect(getByRole(body, "link", { name: url }).getAttribute("href")).toBe(url);
  act(() => {
    state.link.value = { is: "connected" };
  });
  expect(queryByRole(body, "link", { name: url })).toBeNull();
});

it("shows a notice for a few seconds", () => {
  vi.useFakeTimers();
  act(() => {
    state.notice.value = { text: says("There is no size 9x9.") };
  });
  expect(getByText(body, "There is no size 9x9.")).toBeTruthy();
  act(() => {
    vi.advanceTimersByTime(7000);
  });
  expect(queryByText(body, "There is no size 9x9.")).toBeNull();
});

describe("the tape", () => {
  const WHY = "Picture, sound and driving are recorded, without names.";

  function record(tape: Tape | null, options = {}): void {
    show({ watching: [1], ...options });
    act(() => {
      if (state.room.value) state.room.value = { ...state.room.value, tape };
    });
  }

  it("is not mentioned if nothing is recorded", () => {
    record(null);
    expect(queryByText(body, /recorded/i)).toBeNull();
  });

  it("tells everybody that they are recorded, and why", () => {
    record({ running: true, why: says(WHY) });
    expect(getByText(body, "Recorded")).toBeTruthy();
    expect(getByText(body, WHY)).toBeTruthy();
    expect(queryByText(body, "Keep the last two minutes")).toBeNull();
  });

  it("says why nothing is recorded", () => {
    record({ running: false, why: says("Nothing is recorded: the disk is full.") });
    expect(getByText(body, "Not recorded")).toBeTruthy();
    expect(getByText(body, "Nothing is recorded: the disk is full.")).toBeTruthy();
  });

  it("can be kept by the operator", () => {
    record({ running: true, why: says(WHY) }, { watching: [], operator: 1 });
    getByText(body, "Keep the last two minutes").click();
    expect(actions.keepTape).toHaveBeenCalledOnce();
  });
});
