import { render } from "preact";
import type { Session } from "./actions";
import { learnLater, t } from "./words/words";

const AGAIN_MS = 10_000;

/** Whether the address asks for the view of a screen in a hall: `?view=stage`. */
export function wantsStage(search: string): boolean {
  return new URLSearchParams(search).get("view") === "stage";
}

/** Draws that view once it is loaded; nobody is there to try again, so that it does so itself. */
export async function openStage(
  root: Element,
  session: Session,
  load = async () => (await Promise.all([import("./kiosk/Kiosk"), learnLater()]))[0],
): Promise<void> {
  render(<p role="status">{t("kiosk.loading")}</p>, root);
  try {
    const { Kiosk } = await load();
    render(<Kiosk session={session} />, root);
  } catch {
    render(<p role="alert">{t("kiosk.failed")}</p>, root);
    setTimeout(() => window.location.reload(), AGAIN_MS);
  }
}
