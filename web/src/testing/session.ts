/** A session without a connection, for tests of views. */
import { vi } from "vitest";
import type { Actions, Session } from "../actions";
import { loadPreferences } from "../preferences";
import { createState, type State } from "../state";
import { History } from "../stats/history";

/** Returns real state, and actions that only record their calls. */
export function testSession(state: State = createState(loadPreferences(null))): Session {
  const known = new Map<PropertyKey, unknown>();
  const actions = new Proxy({} as Actions, {
    get(_, name) {
      if (!known.has(name)) known.set(name, vi.fn());
      return known.get(name);
    },
  });
  return {
    state,
    actions,
    history: new History(),
    offered: Promise.resolve(),
    seenServerMs: () => null,
    pictureStream: () => null,
    attachPicture: vi.fn(),
    attachSound: vi.fn(),
    shownPicture: () => null,
    forPhoto: (take) => take(),
    soundLevels: async () => [],
    attachCamera: vi.fn(),
  };
}
