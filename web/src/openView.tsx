import { type ComponentType, render } from "preact";
import type { Session } from "./actions";
import { isFramed } from "./framed";
import { loadLaterEnglish, t } from "./words/words";

const AGAIN_MS = 10_000;

type View = ComponentType<{ session: Session }>;

/** What loads a frame's or a big screen's view; null for the normal page. */
export function viewOf(search: string): (() => Promise<View>) | null {
  if (isFramed()) return async () => (await import("./embed/Embed")).Embed;
  // The big screen was once called `stage`.
  if (!["big-screen", "stage"].includes(new URLSearchParams(search).get("view") ?? "")) return null;
  return async () => (await import("./bigScreen/BigScreen")).BigScreen;
}

/** Draws a view once it is loaded; retries by itself, because nobody attends it. */
export async function openView(
  root: Element,
  session: Session,
  load: () => Promise<View>,
): Promise<void> {
  render(<p role="status">{t("big_screen.loading")}</p>, root);
  try {
    const [View] = await Promise.all([load(), loadLaterEnglish()]);
    render(<View session={session} />, root);
  } catch {
    render(<p role="alert">{t("big_screen.failed")}</p>, root);
    setTimeout(() => window.location.reload(), AGAIN_MS);
  }
}
