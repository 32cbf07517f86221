// @vitest-environment dom
import { getByRole, getByText, queryByRole } from "@testing-library/dom";
import type { ComponentType } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import * as files from "../download";
import * as snapshots from "../snapshot";
import { draw, undraw } from "../testing/draw";
import { hello, playout, room } from "../testing/messages";
import { testSession } from "../testing/session";
import { Fullscreen } from "./Fullscreen";
import { OutputChoice } from "./OutputChoice";
import { PictureInPicture } from "./PictureInPicture";
import { Snapshot } from "./Snapshot";
import { Timing } from "./Timing";
import { Volume } from "./Volume";

const { body } = document;
let session: Session;
let video: HTMLVideoElement;

beforeEach(() => {
  video = document.createElement("video");
  Object.defineProperty(video, "videoWidth", { value: 640, configurable: true });
  session = { ...testSession(), shownPicture: () => video };
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 1 });
  session.state.room.value = room({ watching: [1] });
});

afterEach(undraw);

function open(View: ComponentType): void {
  draw(session, <View />);
}

const button = (name: string) => getByRole<HTMLButtonElement>(body, "button", { name });
/** Lets everything pending finish. */
const settle = () => act(() => new Promise<void>((done) => setTimeout(done)));
const press = async (name: string) => {
  act(() => button(name).click());
  await settle();
};
const told = () => queryByRole(body, "alert")?.textContent ?? "";

function blank(): void {
  act(() => {
    const now = room({ watching: [1] });
    session.state.room.value = { ...now, host_settings: { ...now.host_settings, blanked: true } };
  });
}

describe("a photo", () => {
  let saved: ReturnType<typeof vi.spyOn>;

  beforeEach(() => {
    saved = vi.spyOn(files, "download").mockImplementation(() => {});
    vi.spyOn(snapshots, "pictureOf").mockImplementation(async () => new Blob(["p"]));
    open(Snapshot);
  });

  it("is saved with the robot's name and the time", async () => {
    await press("Take a photo");
    expect(saved).toHaveBeenCalledOnce();
    expect(saved.mock.calls[0]?.[1]).toMatch(/^wax-\d{4}-[\d-]+\.png$/);
    expect(told()).toBe("");
  });

  it.each<[string, () => void]>([
    [
      "is not live",
      () =>
        act(() => {
          session.state.link.value = { is: "closed" };
        }),
    ],
    [
      "is not live",
      () =>
        act(() => {
          session.state.facts.value = { ...session.state.facts.peek(), pictureMs: 4000 };
        }),
    ],
    ["host has switched", blank],
    [
      "picture is off",
      () =>
        act(() => {
          session.state.preferences.value = {
            ...session.state.preferences.peek(),
            picture: false,
          };
        }),
    ],
    [
      "no picture yet",
      () => Object.defineProperty(video, "videoWidth", { value: 0, configurable: true }),
    ],
  ])("is refused with a sentence: %s", async (why, change) => {
    change();
    await press("Take a photo");
    expect(saved).not.toHaveBeenCalled();
    expect(told()).toContain(why);
  });

  it("of a camera other than the driving view is judged by that camera", async () => {
    act(() => {
      session.state.large.value = 0;
      session.state.facts.value = { ...session.state.facts.peek(), pictureMs: 4000 };
    });
    await press("Take a photo");
    expect(saved).toHaveBeenCalledOnce();
    act(() => {
      session.state.staleCameras.value = new Set([0]);
    });
    await press("Take a photo");
    expect(saved).toHaveBeenCalledOnce();
    expect(told()).toContain("not live");
  });

  it("that the browser cannot save is reported", async () => {
    vi.spyOn(snapshots, "pictureOf").mockRejectedValueOnce(new Error("tainted"));
    await press("Take a photo");
    expect(told()).toContain("could not save");
  });
});

describe("picture in picture", () => {
  let inPicture: Element | null;
  let refuse: Error | null;

  beforeEach(() => {
    inPicture = null;
    refuse = null;
    Object.defineProperties(document, {
      pictureInPictureEnabled: { value: true, configurable: true },
      pictureInPictureElement: { get: () => inPicture, configurable: true },
    });
    document.exitPictureInPicture = vi.fn(async () => {
      const left = inPicture;
      inPicture = null;
      left?.dispatchEvent(new Event("leavepictureinpicture"));
    });
    HTMLVideoElement.prototype.requestPictureInPicture = vi.fn(async function (
      this: HTMLVideoElement,
    ) {
      if (refuse) throw refuse;
      inPicture = this;
      return {} as PictureInPictureWindow;
    });
  });

  afterEach(() => {
    Reflect.deleteProperty(HTMLVideoElement.prototype, "requestPictureInPicture");
  });

  it("leaves the page and comes back", async () => {
    open(PictureInPicture);
    await press("Picture in picture");
    expect(inPicture).toBe(video);
    await press("Back into the page");
    expect(inPicture).toBeNull();
    expect(button("Picture in picture").disabled).toBe(false);
  });

  it("notices that its window was closed", async () => {
    open(PictureInPicture);
    await press("Picture in picture");
    act(() => void document.exitPictureInPicture?.());
    await settle();
    expect(button("Picture in picture")).toBeTruthy();
  });

  it("comes back when the host blanks it, or when it is not live", async () => {
    open(PictureInPicture);
    await press("Picture in picture");
    blank();
    await settle();
    expect(inPicture).toBeNull();
    expect(told()).toContain("not live");
    expect(button("Picture in picture").disabled).toBe(true);
  });

  it("comes back with the page's last view", async () => {
    open(PictureInPicture);
    await press("Picture in picture");
    undraw();
    await settle();
    expect(inPicture).toBeNull();
  });

  it("says so if the browser refuses", async () => {
    refuse = new DOMException("no", "InvalidStateError");
    open(PictureInPicture);
    await press("Picture in picture");
    expect(told()).toContain("does not show");
  });

  it("is hidden where there is none", () => {
    Reflect.deleteProperty(HTMLVideoElement.prototype, "requestPictureInPicture");
    open(PictureInPicture);
    expect(queryByRole(body, "button")).toBeNull();
  });
});

describe("fullscreen", () => {
  function browser(has: object): void {
    for (const name of ["fullscreenEnabled", "fullscreenElement"]) {
      Object.defineProperty(document, name, {
        value: undefined,
        configurable: true,
        writable: true,
      });
    }
    Object.assign(document, has);
  }

  it("covers the whole page, and can be left", async () => {
    browser({ fullscreenEnabled: true });
    document.documentElement.requestFullscreen = vi.fn(async () => {
      Object.assign(document, { fullscreenElement: document.documentElement });
      document.dispatchEvent(new Event("fullscreenchange"));
    });
    document.exitFullscreen = vi.fn(async () => {
      Object.assign(document, { fullscreenElement: null });
      document.dispatchEvent(new Event("fullscreenchange"));
    });
    open(Fullscreen);
    await press("Fullscreen");
    expect(document.documentElement.requestFullscreen).toHaveBeenCalledOnce();
    await press("Leave fullscreen");
    expect(button("Fullscreen")).toBeTruthy();
  });

  it("says so if it is refused", async () => {
    browser({ fullscreenEnabled: true });
    document.documentElement.requestFullscreen = async () => {
      throw new TypeError("denied");
    };
    open(Fullscreen);
    await press("Fullscreen");
    expect(told()).toContain("does not show");
  });

  it("is the video's own on an iPhone, but not for the operator", async () => {
    browser({});
    const enter = vi.fn();
    Object.assign(video, { webkitEnterFullscreen: enter });
    open(Fullscreen);
    await press("Fullscreen");
    expect(enter).toHaveBeenCalledOnce();
    act(() => {
      session.state.room.value = room({ operator: 1 });
    });
    expect(queryByRole(body, "button")).toBeNull();
  });

  it("is hidden where there is none", () => {
    browser({});
    open(Fullscreen);
    expect(queryByRole(body, "button")).toBeNull();
  });
});

describe("smooth or immediate", () => {
  it("is chosen, with a description of each", () => {
    open(Timing);
    expect(getByRole<HTMLInputElement>(body, "radio", { name: "Automatic" }).checked).toBe(true);
    act(() => getByRole(body, "radio", { name: "Immediate" }).click());
    expect(session.actions.setPolicy).toHaveBeenLastCalledWith("video-first");
    act(() => getByRole(body, "radio", { name: "Smooth" }).click());
    expect(session.actions.setPolicy).toHaveBeenLastCalledWith("audio-master");
  });

  it("is not offered if the server sets one for everybody", () => {
    session.state.playout.value = playout({ policy: "thesis" });
    open(Timing);
    expect(queryByRole(body, "radio")).toBeNull();
  });
});

describe("the volume", () => {
  it("is a slider in percent, and a button that mutes", async () => {
    session.state.isSoundOn.value = true;
    session.state.preferences.value = { ...session.state.preferences.peek(), volume: 0.4 };
    open(Volume);
    const slider = getByRole<HTMLInputElement>(body, "slider", { name: "Volume" });
    expect(slider.value).toBe("40");
    expect(slider.getAttribute("aria-valuetext")).toBe("40 %");
    slider.value = "70";
    act(() => void slider.dispatchEvent(new Event("input", { bubbles: true })));
    expect(session.actions.setVolume).toHaveBeenCalledWith(0.7);
    await press("Mute");
    expect(session.actions.toggleMute).toHaveBeenCalledOnce();
  });

  it("says that nothing is heard while muted, or before the sound is on", () => {
    open(Volume);
    expect(button("Unmute")).toBeTruthy();
    act(() => {
      session.state.isSoundOn.value = true;
      session.state.preferences.value = { ...session.state.preferences.peek(), muted: true };
    });
    expect(button("Unmute")).toBeTruthy();
  });
});

describe("the output", () => {
  const HEADPHONES = { kind: "audiooutput", deviceId: "h", label: "Headphones" };

  function browser(devices: object[], more = {}): void {
    Object.defineProperty(HTMLMediaElement.prototype, "setSinkId", {
      value: async () => {},
      configurable: true,
    });
    const mediaDevices = Object.assign(new EventTarget(), {
      enumerateDevices: async () => devices,
      ...more,
    });
    vi.stubGlobal("navigator", { mediaDevices });
  }

  afterEach(() => {
    Reflect.deleteProperty(HTMLMediaElement.prototype, "setSinkId");
  });

  it("is chosen from those that the browser names", async () => {
    browser([HEADPHONES]);
    open(OutputChoice);
    await settle();
    const choice = getByRole<HTMLSelectElement>(body, "combobox", { name: "Play sound on" });
    choice.value = "h";
    act(() => void choice.dispatchEvent(new Event("change", { bubbles: true })));
    expect(session.actions.setOutput).toHaveBeenLastCalledWith({ id: "h", name: "Headphones" });
    choice.value = "";
    act(() => void choice.dispatchEvent(new Event("change", { bubbles: true })));
    expect(session.actions.setOutput).toHaveBeenLastCalledWith(null);
  });

  it("is chosen in the browser's own dialog if it has one", async () => {
    browser([], { selectAudioOutput: async () => HEADPHONES });
    open(OutputChoice);
    await press("Choose another device…");
    expect(session.actions.setOutput).toHaveBeenCalledWith({ id: "h", name: "Headphones" });
  });

  it("says why none is named", async () => {
    browser([{ kind: "audiooutput", deviceId: "", label: "" }]);
    open(OutputChoice);
    await settle();
    expect(getByText(body, /^Your browser names the devices/)).toBeTruthy();
  });

  it("is hidden if a page cannot choose", () => {
    vi.stubGlobal("navigator", {});
    open(OutputChoice);
    expect(body.textContent).toBe("");
  });
});
