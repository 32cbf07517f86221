/** Keeps a big screen or a frame running for weeks: reconnects, and reloads for a new version. */

import { effect } from "@preact/signals";
import type { Session } from "../actions";

/** The pause after the server has sent the page away without saying until when. */
const COMES_BACK_MS = 60_000;

interface Page {
  /** Loads the page anew. */
  reload(): void;
}

/**
 * Makes the page only watch, with a picture, whatever was chosen in this browser before; reconnects
 * after it was sent away, and reloads when the server has another version. Returns what ends this.
 */
export function keepRunning({ state, actions }: Session, page: Page = window.location): () => void {
  let version: string | null = null;
  const ends = [
    effect(() => {
      // A turn or place may have been kept for a user who drove in this browser.
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
