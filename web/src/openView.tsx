import { type ComponentType, render } from "preact";
import type { Session } from "./actions";
import { isFramed } from "./framed";
import { loadLaterEnglish, t } from "./words/words";

const AGAIN_MS = 10_000;

/** The module of a view. */
interface Module {
  View: ComponentType<{ session: Session }>;
}

/** What loads a frame's, a big screen's or `wax glass`'s view; null for the normal page. */
export function viewOf(search: string): (() => Promise<Module>) | null {
  if (isFramed()) return () => import("./embed/Embed");
  switch (new URLSearchParams(search).get("view")) {
    case "big-screen":
    case "stage": // its name of old
      return () => import("./bigScreen/BigScreen");
    case "glass":
      return () => import("./glass/Glass");
    default:
      return null;
  }
}

/** Draws a view once it is loaded; retries by itself, because nobody attends it. */
export async function openView(
  root: Element,
  session: Session,
  load: () => Promise<Module>,
): Promise<void> {
  render(<p role="status">{t("big_screen.loading")}</p>, root);
  try {
    const [{ View }] = await Promise.all([load(), loadLaterEnglish()]);
    render(<View session={session} />, root);
  } catch {
    render(<p role="alert">{t("big_screen.failed")}</p>, root);
    setTimeout(() => window.location.reload(), AGAIN_MS);
  }
}
