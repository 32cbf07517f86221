const NAMED = /^[A-Z][A-Za-z0-9]+$/;

/**
 * Which key an event is of, by its place on the keyboard (UI Events, 4.3.1), or else by its name:
 * on-screen and remote keyboards and assistive switches say no `code`. Empty where nothing tells.
 */
export function codeOf({ code, key }: Pick<KeyboardEvent, "code" | "key">): string {
  if (code) return code;
  if (key === " " || key === "Spacebar") return "Space";
  if (/^[a-z]$/i.test(key)) return `Key${key.toUpperCase()}`;
  if (/^[0-9]$/.test(key)) return `Digit${key}`;
  return NAMED.test(key) ? key : "";
}
