/** The user's choices on this device, kept between visits if the browser allows it. */

import {
  DRIVE_DEFAULTS,
  type DrivePreferences,
  loadDrivePreferences,
} from "./drive/drivePreferences";
import type { Want } from "./messages";

export interface Preferences extends DrivePreferences {
  name: string;
  sound: boolean;
  picture: boolean;
  /** Whether cameras other than the driving view are shown small. */
  cameras: boolean;
  /** The largest picture, as `640x480`; empty for the largest available. */
  size: string;
  /** How picture and sound are synchronised; null means the role's default. */
  policy: Want["policy"];
  speed: "slow" | "fast";
  /** Whether the predicted path is drawn on the picture. */
  path: boolean;
  /** Whether the user has driven here, or has read how to. */
  welcomed: boolean;
  /** Which player plays the sound; null means the server's choice. */
  player: "browser" | "built-in" | null;
  /** Whether the browser shows a notification when it is their turn. */
  tells: boolean;
  /** The page's language, as a tag; null means the host's or the browser's choice. */
  language: string | null;
  /** From 0 to 1. */
  volume: number;
  muted: boolean;
}

export const PLAYERS = [null, "built-in", "browser"] as const;
export const POLICIES = [null, "audio-master", "video-first"] as const;

const KEY = "wax-preferences";

const DEFAULTS: Preferences = {
  name: "",
  sound: true,
  picture: true,
  cameras: true,
  size: "",
  policy: null,
  speed: "slow",
  path: true,
  welcomed: false,
  tells: false,
  player: null,
  language: null,
  volume: 1,
  muted: false,
  ...DRIVE_DEFAULTS,
};

type Store = Pick<Storage, "getItem" | "setItem">;

/** `window.localStorage` or similar; null where it is forbidden, as when cookies are blocked. */
export function openStore<Opened>(open: () => Opened): Opened | null {
  try {
    return open();
  } catch {
    return null;
  }
}

/** Returns the stored choices, with defaults for missing or invalid ones. */
export function loadPreferences(store: Store | null): Preferences {
  const kept = parse(store);
  return {
    name: typeof kept.name === "string" ? kept.name : DEFAULTS.name,
    sound: typeof kept.sound === "boolean" ? kept.sound : DEFAULTS.sound,
    picture: typeof kept.picture === "boolean" ? kept.picture : DEFAULTS.picture,
    cameras: typeof kept.cameras === "boolean" ? kept.cameras : DEFAULTS.cameras,
    size: typeof kept.size === "string" ? kept.size : DEFAULTS.size,
    policy: POLICIES.find((one) => one === kept.policy) ?? DEFAULTS.policy,
    speed: kept.speed === "fast" ? "fast" : DEFAULTS.speed,
    path: typeof kept.path === "boolean" ? kept.path : DEFAULTS.path,
    welcomed: typeof kept.welcomed === "boolean" ? kept.welcomed : DEFAULTS.welcomed,
    tells: kept.tells === true,
    // The built-in player was once called "own".
    player:
      PLAYERS.find((one) => one === (kept.player === "own" ? "built-in" : kept.player)) ?? null,
    language: typeof kept.language === "string" ? kept.language : DEFAULTS.language,
    volume: isShare(kept.volume) ? kept.volume : DEFAULTS.volume,
    muted: kept.muted === true,
    ...loadDrivePreferences(kept),
  };
}

export function savePreferences(store: Store | null, preferences: Preferences): void {
  try {
    store?.setItem(KEY, JSON.stringify(preferences));
  } catch {
    // If the storage is full or forbidden, the next visit just starts with the defaults.
  }
}

function parse(store: Store | null): Record<string, unknown> {
  try {
    const kept: unknown = JSON.parse(store?.getItem(KEY) ?? "{}");
    return typeof kept === "object" && kept !== null ? { ...kept } : {};
  } catch {
    return {};
  }
}

function isShare(value: unknown): value is number {
  return typeof value === "number" && value >= 0 && value <= 1;
}
