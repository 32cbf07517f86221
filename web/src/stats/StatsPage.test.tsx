// @vitest-environment dom
import { getAllByRole, getByRole, getByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, expect, it, vi } from "vitest";
import type { Session } from "../actions";
import * as files from "../download";
import { draw, undraw } from "../testing/draw";
import { hello, room } from "../testing/messages";
import { sample } from "../testing/samples";
import { testSession } from "../testing/session";
import { StatsPage } from "./StatsPage";

/** This DOM has no canvas; the drawing is checked in a browser. */
const { charts } = vi.hoisted(() => ({ charts: [] as { data: unknown[][]; isGone: boolean }[] }));
vi.mock("uplot", () => ({
  default: class {
    isGone = false;
    constructor(
      _options: unknown,
      public data: unknown[][],
    ) {
      charts.push(this);
    }
    setData(data: unknown[][]) {
      this.data = data;
    }
    setSize() {}
    destroy() {
      this.isGone = true;
    }
  },
}));

let session: Session;
const { body } = document;

beforeEach(() => {
  vi.useFakeTimers({ now: 0 });
  charts.splice(0);
  session = testSession();
  session.state.link.value = { is: "connected" };
  session.state.hello.value = hello({ viewer: 1 });
  session.state.room.value = room({ watching: [1] });
});

afterEach(undraw);

function open(): void {
  draw(session, <StatsPage />);
}

function measure(more: object): void {
  session.history.add(sample(performance.now(), more));
}

/** The cells of the row with this header. */
function row(name: string): string[] {
  const cells = getByRole(body, "rowheader", { name }).parentElement?.querySelectorAll("td");
  return [...(cells ?? [])].map((cell) => cell.textContent ?? "");
}

it("has a table with the same data for each plot", () => {
  for (const linkBps of [100_000, 300_000, 200_000]) {
    measure({ linkBps, pictureMs: 80, soundMs: null });
    vi.advanceTimersByTime(1000);
  }
  open();
  expect(getAllByRole(body, "table")).toHaveLength(7);
  expect(charts).toHaveLength(7);
  expect(row("carries")).toEqual(["100", "200", "300", "200"]);
  expect(row("picture")).toEqual(["80", "80", "80", "80"]);
  expect(row("sound")).toEqual(["–", "–", "–", "–"]);
});

it("says why it is slow", () => {
  measure({ linkBps: 180_000, widthPx: 320, askedPx: 640 });
  open();
  expect(
    getByText(body, "Your link carries 180 kbit/s; that is why the picture is small."),
  ).toBeTruthy();
});

it("updates by itself, and pauses on request", () => {
  measure({ pictureMs: 50 });
  open();
  vi.advanceTimersByTime(500);
  measure({ pictureMs: 90 });
  act(() => void vi.advanceTimersByTime(1000));
  expect(row("picture")).toEqual(["50", "70", "90", "90"]);
  expect(charts[0]?.data[1]).toEqual([50, 90]);
  act(() => getByRole(body, "button", { name: "Pause" }).click());
  measure({ pictureMs: 10 });
  act(() => void vi.advanceTimersByTime(3000));
  expect(row("picture")).toEqual(["50", "70", "90", "90"]);
  act(() => getByRole(body, "button", { name: "Resume" }).click());
  act(() => void vi.advanceTimersByTime(1000));
  expect(row("picture")).toEqual(["10", "50", "90", "10"]);
});

it("starts paused for users who want reduced motion", () => {
  vi.stubGlobal("matchMedia", (query: string) => ({
    matches: query.includes("reduced-motion"),
    addEventListener: () => {},
  }));
  open();
  expect(getByRole(body, "button", { name: "Resume" })).toBeTruthy();
});

it("lists what happened, newest first", () => {
  session.history.mark({ atMs: 0, kind: "link", text: "Connected" });
  session.history.mark({ atMs: 59_000, kind: "stop", text: "Stop is pressed" });
  vi.advanceTimersByTime(120_000);
  open();
  expect(getAllByRole(body, "listitem").map((one) => one.textContent)).toEqual([
    "61 seconds ago Stop is pressed",
    "2 minutes ago Connected",
  ]);
});

it("saves a file with the history, without names", async () => {
  const saved = vi.spyOn(files, "download").mockImplementation(() => {});
  measure({ pictureMs: 50 });
  open();
  act(() => getByRole(body, "button", { name: "Save for a bug report" }).click());
  const [content, name] = saved.mock.calls[0] ?? [];
  expect(name).toMatch(/^wax-stats-[\d-]+\.json$/);
  const text = (await content?.text()) ?? "";
  expect(text).not.toContain("Ada");
  expect(JSON.parse(text)).toMatchObject({
    schema: "wax-stats",
    role: "observer",
    samples: { picture_ms: [50] },
  });
});

it("leaves no plot behind", () => {
  open();
  undraw();
  expect(charts.every((one) => one.isGone)).toBe(true);
});
