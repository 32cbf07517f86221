// @vitest-environment dom
import { beforeEach, describe, expect, it, vi } from "vitest";
import { loadPreferences } from "./preferences";
import { createState, type State } from "./state";
import { hello } from "./testing/messages";
import { enlargement, enough, WantedSize } from "./wantedSize";

const SIZES = ["1280x720", "640x360", "320x180"];
const SETTLED_MS = 2000;

it.each([
  [1400, null, "1280x720"],
  [641, null, "1280x720"],
  [640, null, "640x360"],
  [641, "1280x720", "1280x720"],
  [760, "640x360", "640x360"],
  [780, "640x360", "1280x720"],
  [100, "640x360", "320x180"],
])("for a picture %i pixels wide, with %s in force, %s is enough", (width, inForce, size) => {
  expect(enough(SIZES, { width, height: 10_000 }, inForce)).toBe(size);
});

it("says by how much a picture is enlarged to fill a box without losing its shape", () => {
  expect(enlargement("640x480", { width: 1600, height: 960 })).toBe(2);
});

describe("the page", () => {
  let state: State;
  let asked: (string | undefined)[];
  let wanted: WantedSize;
  let resize: (width: number, height?: number) => void;
  const video = document.createElement("video");

  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal(
      "ResizeObserver",
      class {
        constructor(told: (entries: object[]) => void) {
          resize = (width, height = 10_000) => told([{ contentRect: { width, height } }]);
        }
        observe(): void {}
        disconnect(): void {}
      },
    );
    vi.stubGlobal("devicePixelRatio", 1);
    state = createState(loadPreferences(null));
    asked = [];
    wanted = new WantedSize({ ...state, changed: () => asked.push(wanted.choose()) });
    wanted.attach(video);
    resize(1280);
    state.hello.value = hello({ sizes: SIZES });
    wanted.choose();
  });

  it("asks for nothing before the greeting, then for what its window shows", () => {
    expect(asked).toEqual([]);
    expect(state.size.value).toBe("1280x720");
    state.hello.value = null;
    expect(wanted.choose()).toBeUndefined();
    resize(640);
    state.hello.value = hello({ sizes: SIZES });
    expect(wanted.choose()).toBe("640x360");
  });

  it("asks for less once resizing is over, and for more at once", () => {
    for (const width of [600, 500, 400]) {
      resize(width);
      vi.advanceTimersByTime(SETTLED_MS - 1);
      expect(asked).toEqual([]);
    }
    vi.advanceTimersByTime(1);
    resize(700);
    expect(asked).toEqual(["640x360"]);
    resize(900);
    expect(asked).toEqual(["640x360", "1280x720"]);
    resize(600);
    resize(1280);
    vi.advanceTimersByTime(SETTLED_MS);
    expect(asked).toEqual(["640x360", "1280x720"]);
  });

  it("takes each pixel of CSS for two of the screen at most", () => {
    vi.stubGlobal("devicePixelRatio", 3);
    resize(320);
    expect(wanted.choose()).toBe("640x360");
    resize(390);
    expect(asked).toEqual(["1280x720"]);
  });

  it("never asks for more than the user does, and ignores a picture that is not drawn", () => {
    state.preferences.value = { ...state.preferences.value, size: "640x360" };
    expect(wanted.choose()).toBe("640x360");
    resize(0, 0);
    vi.advanceTimersByTime(SETTLED_MS);
    expect(asked).toEqual([]);
  });

  it("asks for the largest in fullscreen, of the page or of an iPhone's video alone", () => {
    resize(300);
    vi.advanceTimersByTime(SETTLED_MS);
    expect(asked).toEqual(["320x180"]);
    Object.assign(document, { webkitFullscreenElement: document.body });
    document.dispatchEvent(new Event("fullscreenchange"));
    expect(asked.at(-1)).toBe("1280x720");
    Object.assign(document, { webkitFullscreenElement: null });
    document.dispatchEvent(new Event("fullscreenchange"));
    vi.advanceTimersByTime(SETTLED_MS);
    expect(asked.at(-1)).toBe("320x180");
    Object.assign(video, { webkitDisplayingFullscreen: true });
    video.dispatchEvent(new Event("webkitbeginfullscreen"));
    expect(asked.at(-1)).toBe("1280x720");
    Object.assign(video, { webkitDisplayingFullscreen: false });
  });

  it.each([
    ["has come", () => void video.dispatchEvent(new Event("resize"))],
    ["does not come in time", () => void vi.advanceTimersByTime(3000)],
  ])("takes a photo once the largest picture %s, and asks for less again", async (_, then) => {
    resize(300);
    vi.advanceTimersByTime(SETTLED_MS);
    const take = vi.fn(async () => "photo");
    const photo = wanted.forPhoto(take);
    expect(asked.at(-1)).toBe("1280x720");
    expect(take).not.toHaveBeenCalled();
    then();
    expect(await photo).toBe("photo");
    vi.advanceTimersByTime(SETTLED_MS);
    expect(asked).toEqual(["320x180", "1280x720", "320x180"]);
  });

  it("takes a photo of the largest picture without waiting", async () => {
    expect(await wanted.forPhoto(async () => "photo")).toBe("photo");
    expect(asked).toEqual([]);
  });
});
