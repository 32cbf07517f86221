/** What an event tells of its key; some scripts and browsers leave even `key` away. */
export type KeyTelling = Pick<KeyboardEvent, "code" | "key"> &
  Partial<Pick<KeyboardEvent, "isComposing" | "keyCode">>;

/** Names that say of no key which it is. */
const UNTOLD = /^(Process|Dead|Compose|Unidentified|undefined)?$/;
const NAMED = /^[A-Z][A-Za-z0-9]+$/;
/** What an input method says of a key that it keeps for itself (UI Events, 7.3.1). */
const COMPOSING = 229;

/**
 * Which key an event is of, by its place on the keyboard (UI Events, 4.3.1), or else by its name:
 * on-screen and remote keyboards and assistive switches say no `code`. Whatever says space is
 * Space. Empty where nothing tells, and for what an input method has taken, which may keep the
 * release, too.
 */
export function codeOf(event: KeyTelling): string {
  const { isComposing, keyCode } = event;
  const [code, key] = [toldCode(event), toldKey(event)];
  if (code === "Space" || /^(\s|Spacebar)$/.test(key) || (!code && keyCode === 32)) return "Space";
  if (isComposing || keyCode === COMPOSING || event.key === "Process") return "";
  // Without NumLock these are arrows.
  if (code.startsWith("Numpad") && key.startsWith("Arrow")) return key;
  if (code) return code;
  if (/^[a-z]$/i.test(key)) return `Key${key.toUpperCase()}`;
  if (/^[0-9]$/.test(key)) return `Digit${key}`;
  return NAMED.test(key) ? key : "";
}

/** The place that an event tells; empty for none. */
export function toldCode({ code }: KeyTelling): string {
  return UNTOLD.test(String(code)) ? "" : code;
}

/** The name that an event tells; empty for none. */
export function toldKey({ key }: KeyTelling): string {
  return UNTOLD.test(String(key)) ? "" : key;
}
