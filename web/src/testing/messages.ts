/** Messages as the server would send them, for tests. */
import type { Hello, Room, ViewerInfo } from "../messages";

export function hello(more: Partial<Hello> = {}): Hello {
  return {
    type: "hello",
    version: "0.0.0",
    viewer: 1,
    robot: {
      kind: "simulated",
      max_linear_mps: 0.6,
      max_angular_rps: 1.5,
      fine_fraction: 0.3,
      axes: [],
    },
    sizes: ["640x480", "320x240"],
    turn_s: 60,
    grace_s: 3,
    command_rate_hz: 30,
    max_age_ms: 150,
    acknowledge: false,
    ...more,
  };
}

const NAMES = ["Ada", "Bob", "Cleo", "Dan", "Eve"];

export function viewer(id: number, more: Partial<ViewerInfo> = {}): ViewerInfo {
  return {
    id,
    name: NAMES[id - 1] ?? `Guest ${id}`,
    role: "observer",
    place: null,
    wait_s: null,
    lost: false,
    ...more,
  };
}

interface RoomOptions {
  operator?: number;
  waiting?: number[];
  watching?: number[];
  number?: number;
  endsMs?: number;
}

export function room(options: RoomOptions): Room {
  const { operator, waiting = [], watching = [], number = 1, endsMs = 60_000 } = options;
  return {
    type: "room",
    viewers: [
      ...watching.map((id) => viewer(id)),
      ...waiting.map((id, i) => viewer(id, { role: "queued", place: i + 1, wait_s: 30 + 60 * i })),
      ...(operator ? [viewer(operator, { role: "operator", place: 0, wait_s: 0 })] : []),
    ],
    turn: { number, operator: operator ?? null, ends_server_ms: operator ? endsMs : null },
    robot: { connected: true, problem: null },
    video: { problem: null },
    audio: { problem: null },
  };
}
