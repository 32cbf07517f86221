// @vitest-environment dom
import {
  getAllByRole,
  getByLabelText,
  getByRole,
  getByText,
  queryByRole,
  queryByText,
} from "@testing-library/dom";
import { act } from "preact/test-utils";
import { describe, expect, it, vi } from "vitest";
import type { Console, InvitationLink } from "../messages";
import { eventually } from "../testing/eventually";
import { hostConsole, room } from "../testing/messages";
import { says } from "../words/said";
import { actions, body, button, drawsPage, show, showHost, state } from "./page.test.setup";

drawsPage();

function invitation(page: string): InvitationLink {
  return {
    type: "invitation",
    page,
    token: "tok",
    purpose: "queue",
    uses: 1,
    ends_wall_ms: Date.now() + 3_600_000,
  };
}

describe("the host's panel", () => {
  const panel = () => body.querySelector(".host") as HTMLElement;
  const within = (name: string) => getByRole(panel(), "button", { name });
  const line = { id: 2, address: "192.0.2.0/24", invited: true, muted: false };
  const asked = (...acts: object[]) => {
    for (const one of acts) expect(actions.actAsHost).toHaveBeenCalledWith(one);
    expect(actions.actAsHost).toHaveBeenCalledTimes(acts.length);
  };

  function showPeople(): void {
    showHost({ operator: 2, watching: [1] });
    act(() => {
      const now = room({ operator: 2, watching: [1] });
      for (const one of now.viewers) one.host = one.id === 1;
      state.room.value = now;
      state.console.value = hostConsole({
        viewers: [{ ...line, round_trip_ms: 42, picture_ms: 80, rendition: "640x480" }],
      });
    });
  }

  it("is only for the host", () => {
    show({ watching: [1] });
    expect(queryByRole(body, "button", { name: "Host" })).toBeNull();
    act(() => {
      state.panel.value = "host";
    });
    expect(panel()).toBeNull();
    showHost();
    expect(panel()).toBeTruthy();
  });

  it("shows who is here, and how they are connected", () => {
    showPeople();
    const people = getByRole(panel(), "list").textContent;
    expect(people).toContain("Bob drivinginvited");
    expect(people).toContain("192.0.2.0/24 · 42 ms there and back");
    expect(people).toContain("Ada watchinghost");
  });

  it("offers no action against a host", () => {
    showPeople();
    expect(getAllByRole(panel(), "button", { name: "Remove…" })).toHaveLength(1);
  });

  function tells(some: Partial<Console>): void {
    state.console.value = hostConsole(some);
  }

  it("shows who pressed Stop, and asks before it ignores an address", () => {
    showHost();
    expect(queryByText(panel(), "Who pressed Stop")).toBeNull();
    const by = { code: "by.named", values: { name: "Eve" } };
    const presser = { id: 3, address: "192.0.2.0/24", by, presses: 46, muted: false };
    act(() => tells({ pressers: [presser] }));
    expect(panel().textContent).toContain("46 times, last by Eve 192.0.2.0/24");
    act(() => within("Ignore Stop from there…").click());
    act(() => within("Ignore").click());
    act(() => tells({ pressers: [{ ...presser, muted: true }] }));
    act(() => within("Allow Stop from there again").click());
    asked(
      { type: "mute_address", presser: 3, muted: true },
      { type: "mute_address", presser: 3, muted: false },
    );
  });

  it("shows which hook takes no events while that lasts", () => {
    showHost();
    const hook = "1 (example.org)";
    const why = { code: "unreachable.silent", values: { limit: 3 } };
    act(() => tells({ problems: [{ code: "hook.waiting", values: { hook, n: 2, why } }] }));
    expect(getByText(panel(), /2 events wait for hook/).textContent).toBe(
      "2 events wait for hook 1 (example.org). It does not answer within 3 s.",
    );
    act(() => tells({}));
    expect(queryByText(panel(), /wait for hook/)).toBeNull();
  });

  it("warns of a copied cookie, and asks before it signs out the other hosts", () => {
    showHost();
    expect(queryByRole(panel(), "alert")).toBeNull();
    act(() => tells({ reused: "198.51.100.0/24" }));
    expect(getByRole(panel(), "alert").textContent).toContain("from 198.51.100.0/24");
    act(() => within("Sign out the others…").click());
    expect(actions.actAsHost).not.toHaveBeenCalled();
    act(() => within("Sign them out").click());
    asked({ type: "sign_out_others" });
  });

  it("asks once before it removes somebody, and can be cancelled", () => {
    showPeople();
    act(() => within("Remove…").click());
    expect(getByRole(panel(), "alert").textContent).toBe("Remove Bob?");
    act(() => within("Cancel").click());
    expect(actions.actAsHost).not.toHaveBeenCalled();
    act(() => within("Remove…").click());
    act(() => within("Remove").click());
    act(() => within("Remove…").click());
    act(() => within("Remove and keep out for a day").click());
    asked({ type: "remove", viewer: 2, ban: false }, { type: "remove", viewer: 2, ban: true });
  });

  it("mutes a Stop, pauses the queue and ends only this turn", () => {
    showPeople();
    act(() => within("Ignore their Stop").click());
    act(() => getByRole(panel(), "switch", { name: "Pause the queue" }).click());
    act(() => within("End this turn…").click());
    act(() => within("End it").click());
    asked(
      { type: "mute", viewer: 2, muted: true },
      { type: "hold_queue", held: true },
      { type: "end_turn", turn: 1 },
    );
  });

  it("asks before it closes, but locks and blanks at one press", () => {
    showHost();
    act(() => within("Only invited people").click());
    act(() => within("Close for today…").click());
    act(() => within("Close").click());
    act(() => getByRole(panel(), "switch", { name: /Picture and sound off/ }).click());
    asked(
      { type: "lock", locked: true },
      { type: "close", closed: true },
      { type: "blank", blanked: true },
    );
  });

  it("reopens", () => {
    showHost();
    act(() => {
      const now = room({ watching: [1] });
      now.host_settings.locked = true;
      state.room.value = now;
      tells({ closed: true });
    });
    act(() => within("Let strangers in again").click());
    act(() => within("Open").click());
    asked({ type: "lock", locked: false }, { type: "close", closed: false });
  });

  it.each([
    ["", window.location.origin],
    ["https://robot.example.org", "https://robot.example.org"],
  ])("makes an invitation as it was chosen, and shows its link (%s)", (page, origin) => {
    showHost();
    act(() => within("Make a link").click());
    asked({ type: "invite", purpose: "queue", uses: 1, valid_s: 86_400 });
    act(() => {
      state.invitation.value = invitation(page);
    });
    const field = getByRole<HTMLInputElement>(panel(), "textbox", { name: "Invitation link" });
    expect(field.value).toBe(`${origin}/#invite=tok`);
  });

  it("invites to the page's own address, also below a proxy's path", () => {
    window.history.replaceState(null, "", "/robot/?lang=en");
    state.invitation.value = invitation("");
    showHost();
    const field = getByRole<HTMLInputElement>(panel(), "textbox", { name: "Invitation link" });
    expect(field.value).toBe(`${window.location.origin}/robot/#invite=tok`);
    window.history.replaceState(null, "", "/");
  });

  it("has the line for other sites if the page offers one", async () => {
    const html = '<iframe src="https://robot.example.org/?view=embed"></iframe>';
    const fetching = vi.fn(async () => new Response(JSON.stringify({ html })));
    vi.stubGlobal("fetch", fetching);
    showHost();
    const field = () => queryByRole<HTMLInputElement>(panel(), "textbox", { name: "Line of HTML" });
    expect(field()).toBeNull();
    expect(fetching).not.toHaveBeenCalled();
    act(() => {
      state.panel.value = null;
    });
    const about = document.createElement("link");
    about.type = "application/json+oembed";
    about.href = "https://robot.example.org/oembed?url=x&format=json";
    document.head.append(about);
    showHost();
    await act(async () => {});
    await eventually(() => expect(field()?.value).toBe(html));
    expect(fetching).toHaveBeenCalledExactlyOnceWith("oembed?url=x&format=json", {});
    about.remove();
  });

  it("limits the guests' speed", () => {
    showHost();
    const select = getByRole<HTMLSelectElement>(panel(), "combobox", { name: /Guests drive/ });
    act(() => {
      select.value = "0.5";
      select.dispatchEvent(new Event("change", { bubbles: true }));
    });
    asked({ type: "limit_speed", fraction: 0.5 });
  });

  it("shows a message to all, and removes it", () => {
    showHost();
    const field = getByRole<HTMLInputElement>(panel(), "textbox", { name: "Message to all" });
    act(() => {
      field.value = " Tea! ";
      field.dispatchEvent(new Event("input", { bubbles: true }));
    });
    act(() => within("Show").click());
    act(() => {
      const now = room({ watching: [1] });
      now.host_settings.message = "Tea!";
      state.room.value = now;
    });
    act(() => within("Take it away").click());
    const for_s = null;
    asked({ type: "announce", text: "Tea!", for_s }, { type: "announce", text: "", for_s });
    expect(getByText(body, "The host says:").parentElement?.textContent).toBe(
      "The host says: Tea!",
    );
  });
});

it("tells everybody that nobody new can join while the tunnel is down", () => {
  act(() => {
    state.room.value = { ...room({ watching: [1] }), no_way_in: { code: "tunnel.nobody_new" } };
  });
  getByText(body, /^Nobody new can join just now/);
});

describe("a message with an end", () => {
  it.each([
    ["15:00", 9000],
    ["12:30", 24 * 3600],
    ["09:00", 20.5 * 3600],
  ])("goes at %s, the next time that a clock shows it", (time, for_s) => {
    vi.setSystemTime(new Date(2026, 10, 26, 12, 30));
    showHost();
    const write = (field: HTMLInputElement, value: string) =>
      act(() => {
        field.value = value;
        field.dispatchEvent(new Event("input", { bubbles: true }));
      });
    write(getByRole<HTMLInputElement>(body, "textbox", { name: "Message to all" }), "Tea");
    write(getByLabelText<HTMLInputElement>(body, "Until (optional)"), time);
    act(() => button("Show").click());
    expect(actions.actAsHost).toHaveBeenCalledWith({ type: "announce", text: "Tea", for_s });
  });

  it("says until when, in the reader's time", () => {
    vi.setSystemTime(new Date(2026, 10, 26, 12, 30, 20));
    show({ watching: [1] });
    act(() => {
      const now = room({ watching: [1] });
      now.host_settings.message = "Tea";
      // Two and a half hours after the server's time here, minus 20 s.
      now.host_settings.message_ends_server_ms = 18_000 + 8_980_300;
      state.room.value = now;
    });
    const told = getByText(body, "The host says:").parentElement?.textContent;
    expect(told?.replace("\u202f", " ")).toBe("The host says: Tea (until today at 3:00 PM)");
  });
});

describe("the proof of the stop", () => {
  it("is only for the host", () => {
    show({ watching: [1] });
    expect(queryByText(body, "Prove the stop…")).toBeNull();
    showHost();
    expect(getByText(body, "Prove the stop…")).toBeTruthy();
  });

  it("starts only after a new confirmation that the wheels are off the floor", () => {
    showHost();
    const box = getByRole<HTMLInputElement>(body, "checkbox", {
      name: "The wheels are off the floor",
    });
    button("Prove it now").click();
    expect(actions.prove).not.toHaveBeenCalled();
    act(() => box.click());
    act(() => button("Prove it now").click());
    expect(actions.prove).toHaveBeenCalledOnce();
    expect(box.checked).toBe(false);
    expect(button("Prove it now").disabled).toBe(true);
  });

  it("shows its progress, and where its record is", () => {
    showHost();
    act(() => {
      state.proof.value = {
        state: "running",
        line: says("The page is closed (3 of 40)"),
        record: null,
      };
    });
    expect(getByRole(body, "status", { name: "Proof" }).textContent).toContain("3 of 40");
    expect(getByRole<HTMLInputElement>(body, "checkbox").disabled).toBe(true);
    act(() => {
      state.proof.value = { state: "done", line: says("In time."), record: "api/proof/record" };
    });
    const link = getByRole(body, "link", { name: "Open the record" });
    expect(link.getAttribute("href")).toBe("api/proof/record");
  });
});
