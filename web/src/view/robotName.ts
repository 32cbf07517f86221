import type { Hello } from "../messages";

/** The host's name for the robot; before there is a connection, the HTML has it. */
export function robotName(hello: Hello | null): string {
  return hello?.page.name ?? document.documentElement.dataset.name ?? "WAX";
}
