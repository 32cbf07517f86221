/**
 * Messages as the server would send them, for tests: a field with a default in the server's own
 * definition has that value unless the test says otherwise.
 */
import { DEFAULTS } from "../generated/defaults";
import type { Sent } from "../link/signalling";
import type {
  AboardInfo,
  Console,
  ControlInfo,
  Hello,
  Playout,
  RoomState,
  Seat,
  Served,
  StopInfo,
  Told,
  TurnInfo,
  ViewerInfo,
} from "../messages";
import { says } from "../words/said";

/** What the server sends only to the host. */
export function hostConsole(more: Partial<Console> = {}): Console {
  return {
    ...DEFAULTS.Console(),
    viewers: [],
    closed: false,
    opens_wall_ms: null,
    ...more,
  };
}

export function hello(more: Partial<Hello> = {}): Hello {
  return {
    ...DEFAULTS.Hello(),
    version: "0.0.0",
    viewer: 1,
    page: { ...DEFAULTS.PageInfo(), name: "WAX" },
    robot: {
      kind: "simulated",
      max_linear_mps: 0.6,
      max_angular_rps: 1.5,
      slow_fraction: 0.3,
      axes: [],
      motion: { acceleration_mps2: 1.5, acceleration_rps2: 6, braking_mps2: 2 },
      camera: null,
      width_m: null,
    },
    sizes: ["640x480", "320x240"],
    turn_s: 60,
    grace_s: 3,
    command_rate_hz: 30,
    click_to_move: false,
    on_loss: {
      max_age_ms: 150,
      max_command_age_ms: 500,
      slow_picture_age_ms: 400,
      stop_picture_age_ms: 800,
      resume_within_ms: 1000,
      lost_after_ms: 1000,
      max_stop_distance_m: 0.3,
      silence_ms: 120,
      robot_ttl_ms: 200,
      soft_braking: false,
      stop_by: "everybody",
    },
    is_host: false,
    has_microphone: true,
    may_hear: true,
    may_queue: true,
    acknowledge: false,
    ...more,
  };
}

/** The greeting of a robot that also moves sideways. */
export function planar(mine: Hello): Hello {
  return { ...mine, robot: { ...mine.robot, max_lateral_mps: 0.5 } };
}

/** A stop in force, the first. */
export function pressedBy(name: string, more: Partial<StopInfo> = {}): StopInfo {
  return { ...DEFAULTS.StopInfo(), number: 1, by: says(name), ...more };
}

export function control(name: string, more: Partial<ControlInfo> = {}): ControlInfo {
  return {
    name,
    label: name,
    kind: "button",
    min: 0,
    max: 1,
    step: 0.05,
    choices: [],
    key: "",
    pad_button: "",
    moves: false,
    roles: ["operator"],
    ...more,
  };
}

export function playout(more: Partial<Playout> = {}): Playout {
  return {
    ...DEFAULTS.Playout(),
    policy: "audio-master",
    player: "browser",
    sound_target_ms: 40,
    picture_target_ms: null,
    reason: { code: "sync.follows" },
    ...more,
  };
}

export function served(more: Partial<Served> = {}): Served {
  return {
    ...DEFAULTS.Served(),
    rendition: "640x480 at 500 kbit/s",
    picture_hz: 30,
    sound_mu_ms: 20,
    sound_bps: 32_000,
    sound_channels: 1,
    redundancy: 0,
    link_bps: 2_400_000,
    used_bps: 590_000,
    queue_ms: 4,
    in_step: true,
    reason: { code: "sent.all" },
    layers: 3,
    layers_made: 3,
    ...more,
  };
}

/** A seat whose token is like LiveKit's, except for the signature. */
export function seat(name: string, more: Partial<Seat> = {}): Seat {
  const claims = btoa(JSON.stringify({ video: { room: name } })).replaceAll("=", "");
  return { url: "wss://rooms.example.org", token: `e30.${claims}.c2ln`, ...more };
}

export function sentToRoom(more: Partial<Sent> = {}): Sent {
  return {
    ...DEFAULTS.SentToRoom(),
    wall_ms: 0,
    sentMs: 0,
    receivedMs: 0,
    rooms: [seat("one"), seat("two")],
    links: [],
    hello: hello({ viewer: 0 }),
    ...more,
  };
}

export function told(of: RoomState, more: Partial<Told> = {}): Told {
  return { ...DEFAULTS.Told(), server_ms: 0, watching: 1000, room: of, ...more };
}

const NAMES = ["Ada", "Bob", "Cleo", "Dan", "Eve"];

export function viewer(id: number, more: Partial<ViewerInfo> = {}): ViewerInfo {
  return { ...DEFAULTS.ViewerInfo(), id, name: NAMES[id - 1] ?? `Guest ${id}`, ...more };
}

export function aboard(more: Partial<AboardInfo> = {}): AboardInfo {
  return { ...DEFAULTS.AboardInfo(), ...more };
}

export function turn(more: Partial<TurnInfo> = {}): TurnInfo {
  return { ...DEFAULTS.TurnInfo(), number: 1, ...more };
}

interface RoomOptions {
  operator?: number;
  waiting?: number[];
  watching?: number[];
  number?: number;
  endsMs?: number;
  stop?: RoomState["stop"];
}

export function room(options: RoomOptions): RoomState {
  const {
    operator,
    waiting = [],
    watching = [],
    number = 1,
    endsMs = 60_000,
    stop = null,
  } = options;
  return {
    ...DEFAULTS.RoomState(),
    viewers: [
      ...watching.map((id) => viewer(id)),
      ...waiting.map((id, i) => viewer(id, { role: "queued", place: i + 1, wait_s: 30 + 60 * i })),
      ...(operator ? [viewer(operator, { role: "operator", place: 0, wait_s: 0 })] : []),
    ],
    turn: operator ? turn({ number, operator, ends_server_ms: endsMs }) : turn({ number }),
    stop,
    robot: { ...DEFAULTS.RobotStatus(), connected: true },
  };
}
