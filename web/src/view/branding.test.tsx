// @vitest-environment dom
import { getAllByRole, getByRole, getByText, queryByRole, queryByText } from "@testing-library/dom";
import { act } from "preact/test-utils";
import { afterEach, beforeEach, describe, expect, it } from "vitest";
import type { Session } from "../actions";
import { listenFirstDrive } from "../branding/welcome";
import { draw, undraw } from "../testing/draw";
import { hello, room } from "../testing/messages";
import { testSession as made } from "../testing/session";
import { ENGLISH, language } from "../words/words";
import { About } from "./About";
import { robotName } from "./robotName";
import { Welcome } from "./Welcome";

const PAGE = {
  ...hello().page,
  name: "Rover",
  sentence: "A rover in our museum.",
  rules: ["Drive slowly near people.", "سِر ببطء"],
  links: [
    { text: "About us", url: "https://example.org/us" },
    { text: "Write to us", url: "mailto:us@example.org" },
    { text: "Not a link", url: "javascript:alert(1)" },
  ],
};

let session: Session;
const body = document.body;

beforeEach(() => {
  session = made();
});

afterEach(() => {
  undraw();
  language.value = ENGLISH;
  delete document.documentElement.dataset.name;
  delete document.documentElement.dataset.sentence;
});

function greet(more: Parameters<typeof hello>[0] = {}): void {
  act(() => {
    session.state.hello.value = hello({ page: PAGE, ...more });
  });
}

describe("the host's branding", () => {
  it("comes from the HTML before the server's hello", () => {
    document.documentElement.dataset.name = "Rover";
    document.documentElement.dataset.sentence = "Say hello.";
    draw(session, <About />);
    expect(robotName(null)).toBe("Rover");
    expect(getByText(body, "Say hello.")).toBeTruthy();
  });

  it("has the page's own words where the host wrote none", () => {
    draw(session, <About />);
    expect(robotName(null)).toBe("WAX");
    expect(getByText(body, "A real robot that you can drive from here.")).toBeTruthy();
  });

  it("shows the host's words, isolated from the text around them", () => {
    draw(session, <About />);
    greet();
    expect(robotName(session.state.hello.value)).toBe("Rover");
    expect(getByText(body, "A rover in our museum.").tagName).toBe("BDI");
  });
});

describe("the first visit", () => {
  it("explains in three lines what this is, how to drive and how to stop, and shows the rules", () => {
    draw(session, <Welcome />);
    expect(queryByRole(body, "region", { name: "Welcome" })).toBeNull();
    greet({ turn_s: 120 });
    const card = getByRole(body, "region", { name: "Welcome" });
    expect([...card.querySelectorAll("p")].map((line) => line.textContent)).toEqual([
      "A rover in our museum.",
      "Join the queue to drive; a turn lasts 2 minutes.",
      "Everybody can stop the robot at any time: press Stop.",
    ]);
    const rules = getByRole(body, "list", { name: "House rules" });
    expect(rules.querySelectorAll("li > bdi")).toHaveLength(2);
  });

  it.each([
    [{ turn_s: 45 }, "Join the queue to drive; a turn lasts 45 seconds."],
    [{ turn_s: 86_400 }, "Join the queue to drive; when it is your turn, this page tells you."],
    [{ may_queue: false }, "You can watch. To drive, you need an invitation from the host."],
    [
      { on_loss: { ...hello().on_loss, stop_by: "operator" } },
      "The operator and the host can stop the robot at any time.",
    ],
  ] as const)("says what holds here: %j", (more, says) => {
    draw(session, <Welcome />);
    greet(more);
    expect(getByText(body, says)).toBeTruthy();
  });

  it("can be dismissed for good", () => {
    draw(session, <Welcome />);
    greet();
    act(() => getByRole(body, "button", { name: "Got it" }).click());
    expect(session.actions.keep).toHaveBeenCalledWith({ welcomed: true });
    act(() => {
      session.state.preferences.value = { ...session.state.preferences.value, welcomed: true };
    });
    expect(queryByRole(body, "region", { name: "Welcome" })).toBeNull();
  });

  it.each([
    ["ahead", { linear: 0.5, angular: 0 }],
    ["sideways", { linear: 0, angular: 0, lateral: 0.5 }],
  ])("ends with the first drive %s", (_, motion) => {
    const { state } = session;
    const kept: object[] = [];
    const end = listenFirstDrive(state, (change) => kept.push(change));
    state.hello.value = hello();
    state.link.value = { is: "connected" };
    state.motion.value = motion;
    expect(kept).toEqual([]);
    state.motion.value = { linear: 0, angular: 0 };
    state.room.value = room({ operator: 1 });
    expect(kept).toEqual([]);
    state.motion.value = motion;
    expect(kept).toEqual([{ welcomed: true }]);
    end();
  });
});

describe("about this robot", () => {
  it("has the host's rules, and links without a referrer", () => {
    draw(session, <About />);
    greet();
    expect(getByText(body, "Drive slowly near people.")).toBeTruthy();
    const links = getAllByRole(body, "link") as HTMLAnchorElement[];
    expect(links.map((one) => one.getAttribute("href"))).toEqual([
      "https://example.org/us",
      "mailto:us@example.org",
    ]);
    for (const link of links) expect(link.rel).toBe("noopener noreferrer");
    expect(queryByText(body, "Not a link")).toBeNull();
  });

  it("is short if the host wrote nothing", () => {
    draw(session, <About />);
    greet({ page: hello().page });
    expect(queryByRole(body, "list")).toBeNull();
    expect(queryByRole(body, "link")).toBeNull();
  });

  it("shows markup in it as text", () => {
    const hostile = '"><script>window.hurt = 1</script>';
    draw(session, <About />);
    greet({ page: { ...PAGE, sentence: hostile, rules: [hostile] } });
    expect(body.querySelector("script")).toBeNull();
    expect(body.textContent).toContain(hostile);
  });
});
