// @vitest-environment dom
import {
  findByText,
  fireEvent,
  getByLabelText,
  getByRole,
  getByText,
  queryByText,
} from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import type { Session } from "../../actions";
import { type Camera, project } from "../../path/camera";
import { draw, undraw } from "../../testing/draw";
import { hello, room, served } from "../../testing/messages";
import { testSession as made } from "../../testing/session";
import { Calibrate } from "./Calibrate";
import { Calibration } from "./Calibration";

const CAMERA: Camera = { heightM: 0.35, tiltDeg: 15, fovDeg: 70, axisRow: 0.5 };

let session: Session;
const body = document.body;

beforeEach(() => {
  session = made();
  session.state.hello.value = hello({ is_host: true });
  session.state.room.value = room({ operator: 1 });
  session.state.link.value = { is: "connected" };
});

afterEach(undraw);

function type(name: string, value: number): void {
  act(() => {
    fireEvent.input(getByLabelText(body, name), { target: { value: String(value) } });
  });
}

/** Clicks on the picture, which is 480 pixels high and starts at 100. */
function click(row: number): void {
  const picture = getByRole(body, "img", { name: "Picture to click on" });
  picture.getBoundingClientRect = () => new DOMRect(0, 100, 640, 480);
  act(() => {
    fireEvent.click(picture, { clientX: 320, clientY: 100 + 480 * row });
  });
}

function rowOf(aheadM: number): number {
  return project(CAMERA, 4 / 3, { aheadM, leftM: 0 })?.y ?? 0;
}

function lines(): string {
  return (getByLabelText(body, "Lines for the configuration file") as HTMLTextAreaElement).value;
}

const FOUND = "[video]\ncamera_height_m = 0.350\ncamera_tilt_deg = 15.0\ncamera_fov_deg = 70.0";

describe("calibrating the camera", () => {
  it("works by two clicks, and shows the lines for the configuration", () => {
    draw(session, <Calibrate />);
    expect(getByText(body, "Click on the nearer mark.")).toBeTruthy();
    type("Height of the lens, m", 0.35);
    click(rowOf(0.5));
    expect(getByText(body, "Click on the farther mark.")).toBeTruthy();
    click(rowOf(1.5));
    expect(getByText(body, /looks down by 15° and sees 70°/)).toBeTruthy();
    expect(lines()).toBe(FOUND);
    expect(body.querySelector(".path-lane")?.getAttribute("d")).toMatch(/^M/);
  });

  it("moves the mark closest to a further click", () => {
    draw(session, <Calibrate />);
    type("Height of the lens, m", 0.35);
    click(rowOf(0.5) - 0.05);
    click(rowOf(1.5) + 0.02);
    click(rowOf(1.5));
    click(rowOf(0.5));
    expect(lines()).toBe(FOUND);
  });

  it("works by keyboard alone", () => {
    draw(session, <Calibrate />);
    type("Height of the lens, m", 0.35);
    type("Nearer mark, m", 0.6);
    type("Farther mark, m", 2);
    type("Nearer mark in the picture", 1 - rowOf(0.6));
    type("Farther mark in the picture", 1 - rowOf(2));
    expect(lines()).toMatch(/camera_tilt_deg = 1[45]\.\d\ncamera_fov_deg = (69|70|71)\.\d/);
  });

  it("says what is wrong, and keeps what was typed", () => {
    draw(session, <Calibrate />);
    click(rowOf(1.5));
    click(rowOf(0.5));
    expect(getByRole(body, "alert").textContent).toMatch(/nearer mark must be lower/);
    type("Height of the lens, m", 0);
    expect(getByRole(body, "alert").textContent).toMatch(/Type the height/);
    expect(queryByText(body, "Copy")).toBeNull();
  });

  it("copies the lines, or leaves them selected without a clipboard", async () => {
    const writeText = vi.fn(async () => {});
    vi.stubGlobal("navigator", { clipboard: { writeText } });
    draw(session, <Calibrate />);
    type("Height of the lens, m", 0.35);
    click(rowOf(0.5));
    click(rowOf(1.5));
    await act(async () => getByRole(body, "button", { name: "Copy" }).click());
    expect(writeText).toHaveBeenCalledWith(FOUND);
    expect(getByText(body, "Copied.")).toBeTruthy();
    writeText.mockRejectedValueOnce(new Error("not allowed"));
    await act(async () => getByRole(body, "button", { name: "Copy" }).click());
    expect(queryByText(body, "Copied.")).toBeNull();
  });

  it("waits for a picture that looks straight ahead", () => {
    const { state } = session;
    state.hello.value = hello({ robot: { ...hello().robot, axes: ["pan"] } });
    state.axes.value = { pan: 0.5 };
    draw(session, <Calibrate />);
    expect(getByText(body, /The camera is turned aside/)).toBeTruthy();
    act(() => {
      state.preferences.value = { ...state.preferences.value, picture: false };
    });
    expect(getByText(body, /There is no picture now/)).toBeTruthy();
  });

  it("is loaded when the host asks for it", async () => {
    session.state.served.value = served();
    draw(session, <Calibration />);
    expect(queryByText(body, "Click on the nearer mark.")).toBeNull();
    await act(async () => {
      getByRole(body, "button", { name: "Calibrate the camera…" }).click();
    });
    expect(await findByText(body, "Click on the nearer mark.")).toBeTruthy();
  });
});
