import type { State } from "../state";

/** The server's time at a time of the page's clock; null before the first answer. */
export function serverMsAt(
  { serverMs, pageMs }: Pick<State, "serverMs" | "pageMs">,
  atMs: number,
): number | null {
  const told = serverMs.peek();
  return told === null ? null : atMs + told - pageMs.peek();
}
