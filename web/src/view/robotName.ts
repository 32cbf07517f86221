import type { Hello } from "../messages";

/** What the host calls the robot. */
export function robotName(_hello: Hello | null): string {
  return "WAX";
}
