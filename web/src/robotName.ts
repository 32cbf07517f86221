/** The robot's name, as the page's HTML tells it: its title, before anything else writes there. */
const NAME = globalThis.document?.title || "WAX";

export function robotName(): string {
  return NAME;
}
