/** The browser's own notification for a user who waits in a hidden tab. */

import { computed } from "@preact/signals";
import type { State } from "./state";
import { robotName } from "./view/robotName";
import { t } from "./words/words";

/** How long before the turn, if everybody ahead uses their full turn. */
const SOON_S = 15;
const TAG = "turn";

type News = "soon" | "called" | "driving" | null;

/** Whether this browser has notifications and has not denied them to this page. */
export function canNotify(): boolean {
  const has = "Notification" in window && "serviceWorker" in navigator;
  return has && Notification.permission !== "denied";
}

/** Why this browser shows no notification, and what to do about it. */
export type NotTold = "face.tell_refused" | "face.tell_certificate" | "late.failed";

/**
 * Asks for permission, which browsers allow only after a press; null on success. Pending while the
 * user reads the browser's question, and where a worker fails to start.
 */
export async function askToNotify(): Promise<NotTold | null> {
  if ((await Notification.requestPermission()) !== "granted") return "face.tell_refused";
  // Phones show notifications only through a worker; relative, as the page may be below a path.
  const { serviceWorker } = navigator;
  try {
    await serviceWorker.register("tell.js");
    await serviceWorker.ready;
    return null;
  } catch (error) {
    // Browsers load no worker over a certificate that the user has merely clicked through.
    const isUntrusted = (error as Partial<Error> | null)?.name === "SecurityError";
    return isUntrusted ? "face.tell_certificate" : "late.failed";
  }
}

/** Shows each notification once while the page is hidden; withdraws it when it is over or seen. */
export function listenNotifications(state: State): void {
  const news = computed(() => newsOf(state));
  let told: News = null;
  let shown = Promise.resolve();
  const look = () => {
    const now = news.peek();
    if (document.hidden && now === told) return;
    told = now;
    if (!state.preferences.peek().tells || !canNotify()) return;
    const words = document.hidden ? wordsOf(now, state) : null;
    shown = shown.then(() => show(robotName(state.hello.peek()), words)).catch(() => {});
  };
  news.subscribe(look);
  document.addEventListener("visibilitychange", look);
}

function newsOf({ drivingTurn, callSecondsLeft, secondsLeft, me, room }: State): News {
  if (drivingTurn.value !== null) return "driving";
  if (callSecondsLeft.value !== null) return "called";
  if (me.value?.place !== 1 || room.value?.host_settings.held) return null;
  const left = secondsLeft.value;
  return left !== null && left <= SOON_S ? "soon" : null;
}

function wordsOf(news: News, { secondsLeft }: State): string | null {
  switch (news) {
    case "driving":
      return t("turn.you_drive");
    case "called":
      return t("turn.called");
    case "soon":
      return t("face.tell_soon", { seconds: String(secondsLeft.peek()) });
    case null:
      return null;
  }
}

/** Replaces the notification before with these words; null removes it. */
async function show(title: string, words: string | null): Promise<void> {
  const worker = await navigator.serviceWorker.getRegistration();
  for (const old of (await worker?.getNotifications({ tag: TAG })) ?? []) old.close();
  if (words !== null) await worker?.showNotification(title, { body: words, tag: TAG });
}
