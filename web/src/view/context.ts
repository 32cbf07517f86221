/** How a view gets the session: its state (`../state.ts`) and its actions (`../actions.ts`). */

import { createContext } from "preact";
import { useContext } from "preact/hooks";
import type { Actions, Session } from "../actions";
import type { State } from "../state";

export const SessionContext = createContext<Session | null>(null);

export function useSession(): Session {
  const session = useContext(SessionContext);
  if (!session) throw new Error("a view was drawn outside of its session");
  return session;
}

export function useState(): State {
  return useSession().state;
}

export function useActions(): Actions {
  return useSession().actions;
}
