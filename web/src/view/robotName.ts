import type { Hello } from "../messages";

/** What the host calls the robot; the HTML tells it before there is a connection. */
export function robotName(hello: Hello | null): string {
  return hello?.page.name ?? document.documentElement.dataset.name ?? "WAX";
}
