/** What a person chose on this device, kept over visits where the browser lets us. */

import type { Want } from "./messages";

export interface Preferences {
  name: string;
  sound: boolean;
  picture: boolean;
  /** The largest picture, as `640x480`; empty for the largest that there is. */
  size: string;
  /** How picture and sound are kept together; null leaves it to the role. */
  policy: Want["policy"];
  speed: "slow" | "fast";
}

export const POLICIES = [null, "audio-master", "video-first"] as const;

const KEY = "wax-preferences";

const DEFAULTS: Preferences = {
  name: "",
  sound: true,
  picture: true,
  size: "",
  policy: null,
  speed: "slow",
};

type Store = Pick<Storage, "getItem" | "setItem">;

/** `window.localStorage` or its like; null where it is forbidden, as in a private window. */
export function openStore(open: () => Storage): Storage | null {
  try {
    return open();
  } catch {
    return null;
  }
}

/** What was kept, and the default for everything that was not or makes no sense. */
export function loadPreferences(store: Store | null): Preferences {
  const kept = parse(store);
  return {
    name: typeof kept.name === "string" ? kept.name : DEFAULTS.name,
    sound: typeof kept.sound === "boolean" ? kept.sound : DEFAULTS.sound,
    picture: typeof kept.picture === "boolean" ? kept.picture : DEFAULTS.picture,
    size: typeof kept.size === "string" ? kept.size : DEFAULTS.size,
    policy: POLICIES.find((one) => one === kept.policy) ?? DEFAULTS.policy,
    speed: kept.speed === "fast" ? "fast" : DEFAULTS.speed,
  };
}

export function savePreferences(store: Store | null, preferences: Preferences): void {
  try {
    store?.setItem(KEY, JSON.stringify(preferences));
  } catch {
    // A full or forbidden store only means that the next visit starts with the defaults.
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
