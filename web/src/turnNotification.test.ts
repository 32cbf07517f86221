// @vitest-environment dom
import { readFileSync } from "node:fs";
import { beforeEach, expect, it, vi } from "vitest";
import { loadPreferences } from "./preferences";
import { createState, type State } from "./state";
import { hello, room } from "./testing/messages";
import { askToNotify, canNotify, listenNotifications } from "./turnNotification";

let state: State;
let permission: NotificationPermission;
let shown: string[];
const requestPermission = vi.fn(async () => permission);
const register = vi.fn(async () => {});

beforeEach(() => {
  permission = "granted";
  shown = [];
  vi.stubGlobal("Notification", {
    get permission() {
      return permission;
    },
    requestPermission,
  });
  const worker = {
    getNotifications: async () =>
      shown.map((text) => ({ close: () => shown.splice(shown.indexOf(text), 1) })),
    showNotification: async (title: string, { body }: NotificationOptions) => {
      shown.push(`${title}: ${body}`);
    },
  };
  const serviceWorker = { register, ready: Promise.resolve(), getRegistration: async () => worker };
  vi.stubGlobal("navigator", { serviceWorker });
  state = createState({ ...loadPreferences(null), tells: true });
  state.link.value = { is: "connected" };
  state.hello.value = hello({ viewer: 1 });
  listenNotifications(state);
});

async function hides(isHidden: boolean): Promise<void> {
  vi.spyOn(document, "hidden", "get").mockReturnValue(isHidden);
  document.dispatchEvent(new Event("visibilitychange"));
  await settled();
}

async function is(now: Parameters<typeof room>[0], leftS: number, called = false): Promise<void> {
  const call = called ? { viewer: 1, until_server_ms: 60_000 } : null;
  state.room.value = { ...room(now), call };
  state.serverMs.value = 60_000 - leftS * 1000;
  await settled();
}

const settled = () => new Promise((done) => setTimeout(done));
const waits = { operator: 2, waiting: [1] };

it("notifies 15 s before the turn, at the call, and when the turn has begun", async () => {
  await hides(true);
  await is(waits, 16);
  expect(shown).toEqual([]);
  await is(waits, 15);
  expect(shown).toEqual(["WAX: Your turn begins in 15 s."]);
  await is(waits, 14);
  expect(shown).toHaveLength(1);
  await is(waits, 5, true);
  expect(shown).toEqual(["WAX: Your turn is next. Are you ready?"]);
  await is({ operator: 1 }, 60);
  expect(shown).toEqual(["WAX: You are driving"]);
});

it("is withdrawn when the page is shown, and not repeated", async () => {
  await hides(true);
  await is(waits, 15);
  await hides(false);
  expect(shown).toEqual([]);
  await hides(true);
  await is(waits, 10);
  expect(shown).toEqual([]);
});

it("is withdrawn when it is somebody else's turn after all", async () => {
  await hides(true);
  await is(waits, 15);
  await is({ operator: 2, waiting: [3, 1] }, 14);
  expect(shown).toEqual([]);
});

it.each([
  ["a page that is looked at", async () => hides(false)],
  ["who waits behind others", async () => is({ operator: 2, waiting: [3, 1] }, 10)],
  [
    "who has not asked for it",
    async () => {
      state.preferences.value = { ...state.preferences.value, tells: false };
    },
  ],
  [
    "a browser that was told no since",
    async () => {
      permission = "denied";
    },
  ],
])("tells nothing to %s", async (who, make) => {
  await hides(true);
  await make();
  if (!who.includes("behind")) await is(waits, 10);
  expect(shown).toEqual([]);
});

it("is silent while the host has paused the queue", async () => {
  await hides(true);
  const held = room(waits);
  held.host_settings.held = true;
  state.room.value = held;
  state.serverMs.value = 50_000;
  await settled();
  expect(shown).toEqual([]);
});

it("is not offered without notifications, or after a refusal", () => {
  expect(canNotify()).toBe(true);
  permission = "denied";
  expect(canNotify()).toBe(false);
  permission = "default";
  vi.stubGlobal("navigator", {});
  expect(canNotify()).toBe(false);
});

it("registers its worker once allowed, and not if refused", async () => {
  expect(await askToNotify()).toBeNull();
  expect(register).toHaveBeenCalledWith("tell.js");
  register.mockClear();
  permission = "denied";
  expect(await askToNotify()).toBe("face.tell_refused");
  expect(register).not.toHaveBeenCalled();
  permission = "granted";
  register.mockRejectedValueOnce(new TypeError("no such file"));
  expect(await askToNotify()).toBe("late.failed");
});

it("blames the certificate, not a setting, if the browser refuses the worker because of it", async () => {
  const why = "Failed to register a ServiceWorker: An SSL certificate error occurred.";
  register.mockRejectedValueOnce(new DOMException(why, "SecurityError"));
  expect(await askToNotify()).toBe("face.tell_certificate");
});

it("brings the page to the front when clicked", async () => {
  const focus = vi.fn();
  const close = vi.fn();
  let pressed = (_: object) => {};
  const scope = {
    addEventListener: (_: string, listener: (event: object) => void) => {
      pressed = listener;
    },
    clients: { matchAll: async () => [{ focus }] },
  };
  const source = readFileSync(`${import.meta.dirname}/../public/tell.js`, "utf8");
  new Function("self", source)(scope);
  let done = Promise.resolve();
  pressed({
    notification: { close },
    waitUntil: (promise: Promise<void>) => {
      done = promise;
    },
  });
  await done;
  expect(close).toHaveBeenCalledOnce();
  expect(focus).toHaveBeenCalledOnce();
});
