import { beforeEach, describe, expect, it, vi } from "vitest";
import { eventually } from "../testing/eventually";
import { pageSentence, said, says } from "../words/said";
import { Peer } from "./peer";

const STUN = [{ urls: "stun:example.org" }];

const CODECS = ["video/VP8", "video/rtx", "video/VP9", "video/H264", "video/AV1"].map(
  (mimeType) => ({ mimeType, clockRate: 90_000 }),
);

/** A data channel that records what it is given. */
class FakeChannel extends EventTarget {
  readyState = "open";
  bufferedAmount = 0;
  sent: string[] = [];
  send(text: string): void {
    this.sent.push(text);
  }
}

/** The browser's peer connection, as far as an offer needs it. */
class FakeConnection extends EventTarget {
  static made: FakeConnection[] = [];
  iceServers: RTCIceServer[] = [];
  iceGatheringState = "complete";
  localDescription: RTCSessionDescriptionInit | null = null;
  remoteDescription: RTCSessionDescriptionInit | null = null;
  iceConnectionState: RTCIceConnectionState = "new";
  connectionState: RTCPeerConnectionState = "new";

  constructor() {
    super();
    FakeConnection.made.push(this);
  }

  directions: RTCRtpTransceiverDirection[] = [];
  replaceTrack = vi.fn(async () => {});
  setCodecPreferences = vi.fn();
  signalingState = "stable";
  addTransceiver = (_kind: string, { direction }: { direction: RTCRtpTransceiverDirection }) => {
    this.directions.push(direction);
    const { replaceTrack, setCodecPreferences } = this;
    return { receiver: {}, sender: { replaceTrack }, setCodecPreferences };
  };
  channels = new Map<string, FakeChannel>();
  createDataChannel = (name: string) => {
    const channel = new FakeChannel();
    this.channels.set(name, channel);
    return channel;
  };
  createOffer = vi.fn(async () => ({ type: "offer" as const, sdp: offer }));
  createAnswer = async () => ({ type: "answer" as const, sdp: "v=0 our answer" });
  offered = ["video", "audio"].map((kind) => ({
    direction: "recvonly",
    receiver: { track: { kind } },
    sender: {},
  }));
  getTransceivers = () => this.offered;
  getConfiguration = () => ({});
  policy: RTCIceTransportPolicy | undefined;
  setConfiguration({ iceServers = [], iceTransportPolicy }: RTCConfiguration): void {
    this.iceServers = iceServers;
    this.policy = iceTransportPolicy;
  }
  async setLocalDescription(description: RTCSessionDescriptionInit): Promise<void> {
    this.localDescription = description;
  }
  async setRemoteDescription(description: RTCSessionDescriptionInit): Promise<void> {
    this.remoteDescription = description;
  }
  close(): void {}
}

let answer = "v=0 answer";
let offer = "v=0 offer";
let ice: () => Promise<Response>;
let offers: number;
let more: object;

beforeEach(() => {
  FakeConnection.made = [];
  Peer.cannotOffer = false;
  vi.stubGlobal("document", { documentElement: { dataset: {} } });
  vi.stubGlobal("RTCPeerConnection", FakeConnection);
  vi.stubGlobal("RTCRtpReceiver", { getCapabilities: () => ({ codecs: CODECS }) });
  offers = 0;
  more = {};
  offer = "v=0 offer";
  answer = "v=0 answer";
  ice = async () => new Response('{"iceServers": []}');
  vi.stubGlobal("fetch", async (url: string) => {
    if (url === "api/ice") return ice();
    offers++;
    return new Response(JSON.stringify({ sdp: answer, ...more }));
  });
});

const EVENTS = {
  reached: () => {},
  answered: () => {},
  opened: () => {},
  received: () => {},
  lost: () => {},
  refused: () => {},
  sent: () => {},
  offered: () => {},
  receivers: () => {},
};

/** A new peer that connects; the promise resolves when it has its answer or has failed. */
function connect(mayHaveVoice = false) {
  const lost = vi.fn();
  const refused = vi.fn();
  const sent = vi.fn();
  const reached = vi.fn();
  const answered = vi.fn();
  const offered = vi.fn(() => offers);
  const events = {
    reached,
    answered,
    opened: () => {},
    received: () => {},
    lost,
    refused,
    sent,
    offered,
    receivers: () => {},
  };
  const peer = new Peer(events, mayHaveVoice);
  const connected = peer.connect("client");
  const connection = FakeConnection.made.at(-1);
  if (!connection) throw new Error("there is no connection");
  return { peer, connected, connection, lost, refused, sent, reached, answered, offered };
}

it("sends no offer into a dead network, where it might arrive much later", async () => {
  ice = () => Promise.reject(new TypeError("Failed to fetch"));
  const first = connect();
  await first.connected;
  expect(offers).toBe(0);
  expect(first.reached).not.toHaveBeenCalled();
  expect(first.lost).toHaveBeenCalledWith(pageSentence("link.unreachable"), null);

  ice = async () => new Response(JSON.stringify({ iceServers: STUN }));
  const second = connect();
  await second.connected;
  expect(second.connection.iceServers).toEqual(STUN);
  expect(second.reached).toHaveBeenCalledBefore(second.answered);
  expect(offers).toBe(1);
});

it("distinguishes a final refusal from a temporary one", async () => {
  const sentence = { code: "door.closed" };
  const openings = [{ opens_wall_ms: 5, closes_wall_ms: 6 }];
  const body = { error: "The robot is closed.", sentence, ended: true, openings };
  ice = async () => new Response(JSON.stringify(body), { status: 403 });
  const { connected, lost, refused } = connect();
  await connected;
  const ended = { type: "ended", text: sentence, openings };
  const text = { ...ended.text, english: "The robot is closed." };
  expect(refused).toHaveBeenCalledWith({ ...ended, text });
  expect(lost).not.toHaveBeenCalled();
});

it("passes on how long the server asks to wait", async () => {
  ice = async () =>
    new Response('{"error": "Too often."}', { status: 429, headers: { "Retry-After": "7" } });
  const { connected, lost } = connect();
  await connected;
  expect(lost).toHaveBeenCalledWith(says("Too often."), 7000);
});

it.each([
  [false, "all"],
  [true, "relay"],
])("uses nothing but the relay where that is wanted: %s", async (relayOnly, policy) => {
  ice = async () => new Response(JSON.stringify({ iceServers: STUN, relayOnly }));
  const { connected, connection } = connect();
  await connected;
  expect(connection.policy).toBe(policy);
});

it("waits for its candidates only if the server needs them", async () => {
  const tell = (wantsCandidates: boolean) => async () =>
    new Response(JSON.stringify({ iceServers: STUN, wantsCandidates }));
  ice = tell(true);
  const first = connect();
  first.connection.iceGatheringState = "gathering";
  ice = tell(false);
  const second = connect();
  second.connection.iceGatheringState = "gathering";
  await second.connected;
  expect(second.connection.remoteDescription?.sdp).toBe("v=0 answer");
  expect(first.connection.remoteDescription).toBeNull();
  first.connection.iceGatheringState = "complete";
  first.connection.dispatchEvent(new Event("icegatheringstatechange"));
  await first.connected;
  expect(first.connection.remoteDescription?.sdp).toBe("v=0 answer");
});

it("is prepared without sending an offer until it may", async () => {
  const { connection } = connect();
  const peer = new Peer({ ...EVENTS }, false);
  let mayOffer = () => {};
  const connected = peer.connect("client", new Promise((resolve) => (mayOffer = resolve)));
  await eventually(() => expect(connection.remoteDescription?.sdp).toBe("v=0 answer"));
  expect(offers).toBe(1);
  mayOffer();
  await connected;
  expect(offers).toBe(2);
});

it.each([
  ["v=0\r\na=ice-lite\r\n", true],
  ["v=0\r\n", false],
])("may move where the server follows it: %j", async (sdp, mayMove) => {
  answer = sdp;
  const { peer, connected } = connect();
  expect(peer.mayMove).toBe(false);
  await connected;
  expect(peer.mayMove).toBe(mayMove);
});

it("creates the offer during the first request", async () => {
  let answer = (_response: Response) => {};
  ice = () =>
    new Promise((resolve) => {
      answer = resolve;
    });
  const { connected, connection } = connect();
  expect(connection.createOffer).toHaveBeenCalled();
  answer(new Response('{"iceServers": []}'));
  await connected;
  expect(connection.localDescription?.sdp).toBe("v=0 offer");
});

describe("stereo sound", () => {
  beforeEach(() => {
    offer = "v=0\r\na=rtpmap:111 opus/48000/2\r\n";
  });

  it("is requested", async () => {
    const { connected, connection } = connect();
    await connected;
    expect(connection.localDescription?.sdp).toContain("a=fmtp:111 stereo=1");
  });

  it("is optional: the offer of a browser that allows no change is used as it is", async () => {
    const { connected, connection, lost } = connect();
    const apply = connection.setLocalDescription.bind(connection);
    connection.setLocalDescription = (one) =>
      one.sdp === offer ? apply(one) : Promise.reject(new TypeError("modified"));
    await connected;
    expect(connection.localDescription?.sdp).toBe(offer);
    expect(lost).not.toHaveBeenCalled();
  });
});

describe("sending", () => {
  async function channels() {
    const { peer, connected, connection } = connect();
    await connected;
    const drive = connection.channels.get("drive");
    const state = connection.channels.get("state");
    if (!drive || !state) throw new Error("there are no channels");
    return { peer, drive, state };
  }

  it("drops a set-point that would queue, unless it is urgent", async () => {
    const { peer, drive } = await channels();
    drive.bufferedAmount = 300;
    expect(peer.waitingBytes).toBe(300);
    expect(peer.send("drive", "late")).toBe(false);
    expect(peer.send("drive", "zero", true)).toBe(true);
    expect(drive.sent).toEqual(["zero"]);
  });

  it("sends everything over the state channel, however full the other is", async () => {
    const { peer, drive, state } = await channels();
    drive.bufferedAmount = 100_000;
    expect(peer.send("state", "stop")).toBe(true);
    expect(state.sent).toEqual(["stop"]);
  });

  it("reports a channel that is not open", async () => {
    const { peer, state } = await channels();
    state.readyState = "closing";
    expect(peer.send("state", "stop")).toBe(false);
    expect(state.sent).toEqual([]);
  });
});

it("ends if the server is full, and passes on the rooms that it names", async () => {
  const where = { type: "sent_to_room", rooms: [], links: ["https://watch.example.org"] };
  const bodies = { "api/ice": { iceServers: [] }, "api/offer": where };
  vi.stubGlobal("fetch", async (url: keyof typeof bodies) => {
    return new Response(JSON.stringify(bodies[url]));
  });
  const { connected, connection, sent, lost } = connect();
  const closing = vi.spyOn(connection, "close");
  await connected;
  expect(sent).toHaveBeenCalledWith(expect.objectContaining(where));
  expect(closing).toHaveBeenCalledOnce();
  expect(connection.remoteDescription).toBeNull();
  expect(lost).not.toHaveBeenCalled();
});

const STEPS = ["createOffer", "setLocalDescription", "setRemoteDescription"] as const;

async function expectGivenUpAfter4s(lost: unknown, api: string): Promise<void> {
  await vi.advanceTimersByTimeAsync(3999);
  expect(lost).not.toHaveBeenCalled();
  await vi.advanceTimersByTimeAsync(1);
  expect(lost).toHaveBeenCalledExactlyOnceWith(pageSentence("link.browser_hangs", { api }), null);
}

describe("a voice", () => {
  const ANSWER = "v=0\r\nm=audio 9 X 111\r\na=rtpmap:111 opus/48000/2\r\n";
  const track = {} as MediaStreamTrack;

  beforeEach(() => {
    answer = ANSWER;
  });

  it("has room in the first offer only if the server accepts voices", async () => {
    const [withVoice, without] = [connect(true), connect()];
    expect(withVoice.connection.directions).toEqual(["sendrecv", "recvonly"]);
    expect(without.connection.directions).toEqual(["recvonly", "recvonly"]);
    await Promise.all([withVoice.connected, without.connected]);
  });

  it("needs no new connection", async () => {
    const { peer, connected, connection } = connect(true);
    await connected;
    await peer.speak(track);
    expect(connection.replaceTrack).toHaveBeenCalledExactlyOnceWith(track);
    expect(connection.remoteDescription?.sdp).toContain("a=ptime:20");
    expect(offers).toBe(1);
  });

  it("changes its encoding by the same answer, without asking the server", async () => {
    const { peer, connected, connection } = connect(true);
    await connected;
    peer.shape({ bitrateBps: 6000, packetMs: 60 });
    await eventually(() => expect(connection.remoteDescription?.sdp).toContain("a=ptime:60"));
    expect(connection.remoteDescription?.sdp).toContain("maxaveragebitrate=6000");
    expect(offers).toBe(1);
  });

  it("keeps its encoding in a browser that refuses the change", async () => {
    const { peer, connected, connection, lost } = connect(true);
    await connected;
    connection.setRemoteDescription = () => Promise.reject(new TypeError("no"));
    peer.shape({ bitrateBps: 6000, packetMs: 60 });
    await eventually(() => expect(connection.localDescription?.type).toBe("rollback"));
    expect(lost).not.toHaveBeenCalled();
  });

  it.each(STEPS)("changes its encoding within 4 s, or the peer fails: %s", async (api) => {
    const { peer, connected, connection, lost } = connect(true);
    await connected;
    vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout"] });
    const asked = new Promise<void>((resolve) => {
      Object.assign(connection, { [api]: () => new Promise(() => resolve()) });
    });
    peer.shape({ bitrateBps: 6000, packetMs: 60 });
    await asked;
    await expectGivenUpAfter4s(lost, api);
  });

  it("leaves the answer unchanged if there is none", async () => {
    const { peer, connected, connection } = connect();
    await connected;
    await peer.speak(track);
    expect(connection.remoteDescription?.sdp).toBe(ANSWER);
    expect(connection.replaceTrack).not.toHaveBeenCalled();
  });
});

it("offers the codecs that servers send, and no others", async () => {
  const { connected, connection } = connect();
  await connected;
  const [codecs] = connection.setCodecPreferences.mock.lastCall as [{ mimeType: string }[]];
  expect(codecs.map((one) => one.mimeType)).toEqual(["video/VP8", "video/rtx", "video/H264"]);
});

it("reports that the offer was sent before it is answered, so that drawing can go on", async () => {
  const { connected, offered, answered } = connect();
  await connected;
  expect(offered).toHaveReturnedWith(1);
  expect(offered.mock.invocationCallOrder[0]).toBeLessThan(
    answered.mock.invocationCallOrder[0] as number,
  );
});

const CANDIDATES = [
  "v=0",
  "a=candidate:1 1 udp 2130706431 192.0.2.5 8081 typ host",
  "a=candidate:2 1 udp 1694498815 203.0.113.5 8081 typ srflx raddr 0.0.0.0 rport 0",
].join("\r\n");

it.each([
  ["checking", {}, "UDP does not get through"],
  ["failed", { host: true }, "UDP to its port 8081 does not get through"],
  ["connected", {}, "no encrypted connection (DTLS)"],
] as const)("says how far it came where ICE is %s: %j", async (state, told, words) => {
  answer = CANDIDATES;
  more = told;
  const { peer, connected, connection, lost } = connect();
  for (const channel of connection.channels.values()) channel.readyState = "connecting";
  expect(said(peer.trouble)).toBe("The server does not answer.");
  await connected;
  connection.iceConnectionState = state;
  expect(said(peer.trouble)).toContain(words);

  connection.connectionState = "failed";
  connection.dispatchEvent(new Event("connectionstatechange"));
  expect(lost).toHaveBeenCalledWith(peer.trouble, null);
});

it("says why its answer is rejected, even in a separate frame", async () => {
  const { connection, lost } = connect();
  connection.setRemoteDescription = () => Promise.reject({ message: "no such codec" });
  await eventually(() => expect(lost).toHaveBeenCalledWith(says("no such codec"), null));
});

it("does not blame the network if the connection has worked", async () => {
  const { connected, connection, lost } = connect();
  await connected;
  connection.iceConnectionState = "failed";
  connection.connectionState = "failed";
  connection.dispatchEvent(new Event("connectionstatechange"));
  expect(lost).toHaveBeenCalledWith(pageSentence("link.lost"), null);
});

/** From now on this step of the browser's never settles; resolves once it is begun. */
function hangs(api: string): Promise<void> {
  vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout"] });
  return new Promise<void>((resolve) => {
    vi.stubGlobal(
      "RTCPeerConnection",
      class extends FakeConnection {
        constructor() {
          super();
          Object.assign(this, { [api]: () => new Promise(() => resolve()) });
        }
      },
    );
  });
}

it.each(STEPS.slice(1))(
  "fails with a reason after 4 s if the browser never finishes %s",
  async (api) => {
    const asked = hangs(api);
    const { lost } = connect();
    await asked;
    await expectGivenUpAfter4s(lost, api);
  },
);

describe("a browser that never makes an offer", () => {
  let bodies: object[];

  beforeEach(async () => {
    const asked = hangs("createOffer");
    const { lost } = connect();
    await asked;
    await vi.advanceTimersByTimeAsync(2000);
    const why = pageSentence("link.browser_hangs", { api: "createOffer" });
    expect(lost).toHaveBeenCalledExactlyOnceWith(why, null);
    vi.useRealTimers();
    bodies = [];
    vi.stubGlobal("CompressionStream", undefined);
    vi.stubGlobal("fetch", async (url: string, { body }: RequestInit) => {
      if (url === "api/ice") return ice();
      bodies.push(JSON.parse(String(body)));
      const sdp = bodies.length === 1 ? "v=0 the server's" : "";
      return new Response(JSON.stringify({ sdp, host: true }));
    });
  });

  it("takes the server's from the next connection on", async () => {
    const { peer, connected, connection, lost, answered } = connect(true);
    await connected;
    expect(lost).not.toHaveBeenCalled();
    expect(answered).toHaveBeenCalledOnce();
    expect(bodies).toEqual([
      { sdp: "", client: "client" },
      { sdp: "v=0 our answer", client: "client", answers: true },
    ]);
    expect(connection.remoteDescription).toEqual({ type: "offer", sdp: "v=0 the server's" });
    expect(connection.localDescription?.type).toBe("answer");
    const [picture, sound] = connection.offered;
    expect([peer.sound, peer.picture]).toEqual([sound?.receiver, picture?.receiver]);
    expect([sound?.direction, picture?.direction]).toEqual(["sendrecv", "recvonly"]);
    expect(peer.cameras).toEqual([]);
  });

  it("says so if the server offers no picture", async () => {
    const { connected, connection, lost } = connect();
    connection.offered = [];
    await connected;
    expect(lost).toHaveBeenCalledExactlyOnceWith(pageSentence("link.no_description"), null);
  });
});
