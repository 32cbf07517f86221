/** A session with a real state and no connection, whose actions only remember that they were asked. */
import { vi } from "vitest";
import { loadPreferences } from "../preferences";
import type { Actions, Session } from "../session";
import { createState } from "../state";

export function session(): Session {
  const made: Partial<Record<keyof Actions, ReturnType<typeof vi.fn>>> = {};
  const actions = new Proxy({} as Actions, {
    get(_, name: keyof Actions) {
      made[name] ??= vi.fn();
      return made[name];
    },
  });
  return {
    state: createState(loadPreferences(null)),
    actions,
    attachPicture: vi.fn(),
    attachSound: vi.fn(),
    pictureStream: () => null,
    soundLevels: async () => [],
    attachCamera: vi.fn(),
  };
}
