import { render } from "preact";
import type { Session } from "./actions";
import { learnLater, t } from "./words/words";

const AGAIN_MS = 10_000;

/** Whether the address asks for the big screen in a hall: `?view=big-screen`, formerly `stage`. */
export function wantsBigScreen(search: string): boolean {
  return ["big-screen", "stage"].includes(new URLSearchParams(search).get("view") ?? "");
}

/** Draws that view once it is loaded; nobody is there to try again, so that it does so itself. */
export async function openBigScreen(
  root: Element,
  session: Session,
  load = async () => (await Promise.all([import("./bigScreen/BigScreen"), learnLater()]))[0],
): Promise<void> {
  render(<p role="status">{t("big_screen.loading")}</p>, root);
  try {
    const { BigScreen } = await load();
    render(<BigScreen session={session} />, root);
  } catch {
    render(<p role="alert">{t("big_screen.failed")}</p>, root);
    setTimeout(() => window.location.reload(), AGAIN_MS);
  }
}
