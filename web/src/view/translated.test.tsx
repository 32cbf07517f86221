// @vitest-environment dom
import { getByRole, queryByRole } from "@testing-library/dom";
import type { ComponentType } from "preact";
import { act } from "preact/test-utils";
import { afterEach, beforeAll, beforeEach, describe, expect, it, vi } from "vitest";
import type { Actions, Session } from "../actions";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { draw, undraw } from "../testing/draw";
import { aboard, hello, room, served } from "../testing/messages";
import { testSession } from "../testing/session";
import { switchLanguage } from "../words/language";
import { says } from "../words/said";
import { AboardBanner } from "./AboardBanner";
import { App } from "./App";
import { CallCard } from "./CallCard";
import { EndedPage, Hours } from "./EndedPage";
import { HostPanel } from "./host/HostPanel";
import { LanguageChoice } from "./LanguageChoice";
import { LossPanel } from "./LossPanel";
import { Facts, HostPanel as LateHostPanel, RulesPanel } from "./Panels";
import { Queue } from "./Queue";
import { Watching, WaysPanel } from "./Settings";
import { SoundMeter } from "./SoundMeter";
import { StopButton } from "./StopButton";
import { TapeBadge } from "./TapeBadge";
import { Views } from "./Views";
import { VoicePanel } from "./VoicePanel";

const setLanguage = vi.fn();
const body = document.body;
let state: State;
let session: Session;

beforeAll(async () => {
  for (const part of [Facts, LateHostPanel, RulesPanel, Watching, WaysPanel, Hours])
    await part.load();
});

/** The host's page, with as much text as possible. */
beforeEach(() => {
  state = createState(loadPreferences(null));
  const nothing = vi.fn();
  const actions = new Proxy({ setLanguage } as Partial<Actions>, {
    get: (own, name) => own[name as keyof Actions] ?? nothing,
  }) as Actions;
  session = { ...testSession(state), actions, soundLevels: async () => [0.5, 0.5] };
  state.link.value = { is: "connected" };
  state.hello.value = hello({
    viewer: 1,
    is_host: true,
    cameras: [{ name: "7", axes: [] }],
    voice: { open_microphone: true },
  } as Partial<Parameters<typeof hello>[0]>);
  const viewers = room({ operator: 2, waiting: [1], watching: [3, 4] });
  state.room.value = {
    ...viewers,
    viewers: viewers.viewers.map((one) => ({ ...one, name: `${one.id}`, lost: one.id === 3 })),
    call: { viewer: 1, until_server_ms: 9000 },
    stop: null,
    tape: { running: true, why: says("1") },
    voice: { speaker: null, muted: false, problem: null },
    aboard: aboard({ mode: "hand", reason: says("2") }),
    cameras: [{ problem: null }],
  } as NonNullable<typeof state.room.value>;
  state.request.value = { asked: "wait" };
  state.serverMs.value = 4000;
  state.served.value = served({ cameras: [null] });
  state.watching.value = 1000;
  state.console.value = {
    type: "console",
    closed: true,
    opens_wall_ms: Date.now(),
    pressers: [
      { id: 1, address: "192.0.2.0/24", by: { code: "by.host" }, presses: 2, muted: false },
    ],
    reused: "192.0.2.0/24",
    problems: [says("3")],
    viewers: [3, 4].map((id) => ({
      id,
      address: "",
      invited: true,
      muted: id === 3,
      round_trip_ms: 1,
      picture_ms: 2,
      rendition: null,
    })),
  };
  state.invitation.value = {
    type: "invitation",
    token: "1",
    page: "",
    purpose: "queue",
    uses: 2,
    ends_wall_ms: Date.now(),
  };
  state.proof.value = { state: "done", line: says("1"), record: "2" };
});

afterEach(async () => {
  undraw();
  await switchLanguage("en");
});

function show(View: ComponentType): void {
  draw(session, <View />);
}

/** Everything that a person reads, or has read to them, except key labels. */
function read(): string[] {
  const found: string[] = [];
  for (const element of body.querySelectorAll<HTMLElement>("*")) {
    for (const name of ["aria-label", "title", "placeholder"]) {
      const text = element.getAttribute(name);
      if (text) found.push(text);
    }
    for (const node of element.childNodes) {
      if (node.nodeType === Node.TEXT_NODE && element.tagName !== "KBD")
        found.push(node.textContent ?? "");
    }
  }
  return found.filter((text) => /[a-z]/i.test(text));
}

const Picture = () => <Views isShown video={{ current: null }} />;
const Ended = () => (
  <EndedPage
    ended={{
      type: "ended",
      text: says("1"),
      openings: [{ opens_wall_ms: Date.now(), closes_wall_ms: Date.now() }],
    }}
  />
);

describe("in another language", () => {
  it.each([
    ["who is here", Queue],
    ["the call", CallCard],
    ["what fails", LossPanel],
    ["the voice", VoicePanel],
    ["the sound's level", SoundMeter],
    ["the views", Picture],
    ["Stop", StopButton],
    ["the tape", TapeBadge],
    ["who is aboard", AboardBanner],
    ["the host's panel", HostPanel],
    ["the end", Ended],
  ])("%s: nothing is left in English", async (_name, View) => {
    await switchLanguage("pseudo");
    show(View);
    expect(read()).not.toEqual([]);
    // Translated text has marks of direction; the names on this page are numbers.
    const left = read().filter((text) => !/[\u202e]/.test(text) && text !== "WAX");
    expect(left).toEqual([]);
  });

  it.each(["people", "settings", "details", "rules", "host"] as const)(
    "the whole page with its panel %s: nothing is left in English",
    async (panel) => {
      const now = state.room.value;
      if (now) {
        now.turn = { ...now.turn, operator: 1 };
        now.robot = { ...now.robot, connected: false, bumpers: 1, battery_v: 7 };
        now.host_settings = { ...now.host_settings, message: "1" };
        now.viewers = now.viewers.map((one) => (one.id === 1 ? { ...one, role: "operator" } : one));
      }
      state.room.value = now && { ...now };
      state.served.value = served({ reason: says("1"), in_step: false });
      state.entryProblem.value = says("1");
      state.preferences.value = { ...state.preferences.value, picture: false };
      state.panel.value = panel;
      await switchLanguage("pseudo");
      show(() => <App session={session} />);
      const unit = /(?<!\w)(ms|s|kbit\/s|Mbit\/s|V)(?!\w)/g;
      const left = read().filter(
        (text) => /[a-z]/i.test(text.replaceAll(unit, "")) && !text.includes("\u202e"),
      );
      // A key's label is not translated.
      const own = /^(WAX|Deutsch|English|[A-Z])$/;
      expect(left.filter((text) => !own.test(text))).toEqual([]);
    },
  );

  it("everything follows a change at once", async () => {
    show(StopButton);
    expect(getByRole(body, "button", { name: "Stop" })).toBeTruthy();
    await act(async () => {
      await switchLanguage("de");
    });
    expect(getByRole(body, "button", { name: "Stopp" })).toBeTruthy();
    expect(queryByRole(body, "button", { name: "Stop" })).toBeNull();
  });
});

describe("the choice of a language", () => {
  const choose = (value: string) => {
    const select = getByRole<HTMLSelectElement>(body, "combobox", { name: "Language" });
    select.value = value;
    act(() => {
      select.dispatchEvent(new Event("change", { bubbles: true }));
    });
    return select;
  };

  it("has each by its own name, without the pseudo-language", () => {
    show(LanguageChoice);
    const options = [...body.querySelectorAll("option")].map((one) => one.textContent);
    expect(options).toEqual(["Automatic", "English", "Deutsch"]);
  });

  it("shows what was chosen, and takes another or none", () => {
    state.preferences.value = { ...state.preferences.value, language: "de" };
    show(LanguageChoice);
    expect(choose("de").value).toBe("de");
    choose("en");
    expect(setLanguage).toHaveBeenLastCalledWith("en");
    choose("");
    expect(setLanguage).toHaveBeenLastCalledWith(null);
  });
});
