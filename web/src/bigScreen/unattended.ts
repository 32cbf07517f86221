/** Keeps a screen or a frame going for weeks: it comes back, and reloads at another version. */

import { effect } from "@preact/signals";
import type { Session } from "../actions";

/** After the server has sent it away without saying until when. */
const COMES_BACK_MS = 60_000;

interface Page {
  /** Loads the page anew. */
  reload(): void;
}

/**
 * The screen watches only, with a picture, whatever was chosen in this browser before; it comes back
 * after it was sent away, and follows the server to another version. Returns what ends it.
 */
export function tend({ state, actions }: Session, page: Page = window.location): () => void {
  let version: string | null = null;
  const ends = [
    effect(() => {
      // Somebody drove here before, and a place was kept for their return.
      const role = state.me.value?.role;
      if (role === "operator" || role === "queued") actions.leave();
    }),
    effect(() => {
      if (!state.preferences.value.picture) actions.setPicture(true);
    }),
    effect(() => {
      const told = state.hello.value?.version ?? null;
      if (told === null) return;
      if (version !== null && version !== told) page.reload();
      version = told;
    }),
    effect(() => {
      if (!state.ended.value) return;
      const coming = setTimeout(() => actions.comeBack(), COMES_BACK_MS);
      return () => clearTimeout(coming);
    }),
  ];
  return () => {
    for (const end of ends) end();
  };
}
