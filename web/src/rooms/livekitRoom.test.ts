import { beforeEach, expect, it, vi } from "vitest";
import type { Told } from "../messages";
import { eventually } from "../testing/eventually";
import { room, seat, told } from "../testing/messages";
import { LiveKitRoom } from "./livekitRoom";

/** A LiveKit room, as far as the page uses it. */
const livekit = vi.hoisted(() => {
  type Listener = (...values: unknown[]) => void;
  const told = { refuses: false };
  const made: InstanceType<typeof FakeRoom>[] = [];
  class FakeRoom {
    listeners = new Map<string, Listener>();
    remoteParticipants = new Map<string, { trackPublications: Map<string, unknown> }>();
    state = "connecting";
    connect = vi.fn(async () => {
      if (told.refuses) throw new Error("the token has expired");
    });
    disconnect = vi.fn(async () => {});
    constructor(readonly options: object) {
      made.push(this);
    }
    on(event: string, listener: Listener) {
      this.listeners.set(event, listener);
    }
    emit(event: string, ...values: unknown[]) {
      this.listeners.get(event)?.(...values);
    }
  }
  return Object.assign(told, { made, FakeRoom });
});

vi.mock("livekit-client", async () => {
  const { DisconnectReason, RoomEvent, Track } =
    await vi.importActual<typeof import("livekit-client")>("livekit-client");
  return { DisconnectReason, Room: livekit.FakeRoom, RoomEvent, setLogLevel() {}, Track };
});

const [BEST, SMALL] = ["robot 640x480 at 1000 kbit/s", "robot 320x240 at 150 kbit/s"];

let heard: Told[];
let gone: boolean[];

beforeEach(() => {
  livekit.made.length = 0;
  livekit.refuses = false;
  heard = [];
  gone = [];
});

/** A publication whose track arrives once it is subscribed. */
function publication(kind: string) {
  return {
    kind,
    isDesired: false,
    track: undefined as { receiver: object } | undefined,
    setSubscribed: vi.fn(function set(this: { isDesired: boolean }, isWanted: boolean) {
      this.isDesired = isWanted;
    }),
  };
}

function enter() {
  const made = new LiveKitRoom(seat("one"), {
    told: (message) => heard.push(message),
    gone: (isSentAway) => gone.push(isSentAway),
  });
  const fake = livekit.made.at(-1);
  if (!fake) throw new Error("there is no room");
  const best = publication("video");
  const small = publication("video");
  const sound = publication("audio");
  const stranger = publication("video");
  const join = (name: string, ...all: object[]) =>
    fake.remoteParticipants.set(name, {
      trackPublications: new Map(all.map((one, i) => [String(i), one])),
    });
  join(SMALL, small, sound);
  join("somebody", stranger);
  join(BEST, best);
  return { made, fake, best, small, sound, stranger };
}

it("joins without subscriptions, with capture times, and does not reconnect by itself", () => {
  const { fake } = enter();
  expect(fake.options).toMatchObject({ singlePeerConnection: false });
  const { reconnectPolicy } = fake.options as {
    reconnectPolicy: { nextRetryDelayInMs: (context: object) => number | null };
  };
  expect(reconnectPolicy.nextRetryDelayInMs({ retryCount: 0, elapsedMs: 0 })).toBeNull();
  const { url, token } = seat("one");
  expect(fake.connect).toHaveBeenCalledWith(
    url,
    token,
    expect.objectContaining({ autoSubscribe: false }),
  );
});

it("subscribes to one picture and the sound, and to nobody else", () => {
  const { made, best, small, sound, stranger } = enter();
  expect(made.pictures).toEqual([BEST, SMALL]);
  made.watch(BEST, true);
  expect([best, small, sound, stranger].map((one) => one.isDesired)).toEqual([
    true,
    false,
    true,
    false,
  ]);
  made.watch(SMALL, false);
  expect([best, small, sound].map((one) => one.isDesired)).toEqual([false, true, false]);
  made.watch(SMALL, false);
  expect(small.setSubscribed).toHaveBeenCalledOnce();
});

it("finds the receivers that have arrived", () => {
  const { made, best, sound } = enter();
  expect(made.picture(BEST)).toBeNull();
  expect(made.sound).toBeNull();
  best.track = { receiver: {} };
  sound.track = { receiver: {} };
  expect(made.picture(BEST)).toBe(best.track.receiver);
  expect(made.sound).toBe(sound.track.receiver);
});

it("accepts messages only from the robot's server", () => {
  const { fake } = enter();
  const say = (message: object, sender?: object, topic = "wax") =>
    fake.emit("dataReceived", new TextEncoder().encode(JSON.stringify(message)), sender, 0, topic);
  say(told(room({})), { identity: "somebody" });
  say(told(room({})), undefined, "chat");
  say({ type: "another" });
  expect(heard).toEqual([]);
  say(told(room({})));
  expect(heard).toEqual([told(room({}))]);
});

it.each([
  ["the signalling breaks", "signalReconnecting", undefined, false],
  ["the media break", "reconnecting", undefined, false],
  ["it is disconnected", "disconnected", undefined, false],
  ["the page was removed", "disconnected", 4, true],
])("is over, once, when %s", (_, event, reason, isSentAway) => {
  const { fake } = enter();
  fake.emit(event, reason);
  fake.emit("disconnected");
  expect(gone).toEqual([isSentAway]);
});

it("reports nothing after `leave`", () => {
  const { made, fake } = enter();
  fake.state = "connected";
  expect(made.isConnected).toBe(true);
  made.leave();
  fake.emit("disconnected");
  expect(gone).toEqual([]);
  expect(fake.disconnect).toHaveBeenCalledOnce();
  expect(made.isConnected).toBe(false);
});

it("reports its end if it cannot join", async () => {
  livekit.refuses = true;
  enter();
  await eventually(() => expect(gone).toEqual([false]));
});
