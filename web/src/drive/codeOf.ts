/** What identifies the key of an event; some scripts and browsers omit even `key`. */
export type KeyTelling = Pick<KeyboardEvent, "code" | "key"> &
  Partial<Pick<KeyboardEvent, "isComposing" | "keyCode">>;

/** Values that identify no key. */
const UNTOLD = /^(Process|Dead|Compose|Unidentified|undefined)?$/;
const NAMED = /^[A-Z][A-Za-z0-9]+$/;
/** The `keyCode` of a key that an input method has consumed (UI Events, 7.3.1). */
const COMPOSING = 229;

/**
 * Returns an event's key, by its position on the keyboard (UI Events, 4.3.1), or else by its name:
 * on-screen and remote keyboards and assistive switches report no `code`. Any sign of a space means
 * Space. Empty if nothing identifies the key, or an input method has consumed it: that may consume
 * the release, too.
 */
export function codeOf(event: KeyTelling): string {
  const { isComposing, keyCode } = event;
  const [code, key] = [toldCode(event), toldKey(event)];
  if (code === "Space" || /^(\s|Spacebar)$/.test(key) || (!code && keyCode === 32)) return "Space";
  if (isComposing || keyCode === COMPOSING || event.key === "Process") return "";
  // Without NumLock the numeric keypad has arrows.
  if (code.startsWith("Numpad") && key.startsWith("Arrow")) return key;
  if (code) return code;
  if (/^[a-z]$/i.test(key)) return `Key${key.toUpperCase()}`;
  if (/^[0-9]$/.test(key)) return `Digit${key}`;
  return NAMED.test(key) ? key : "";
}

/** The key's position as the event reports it; empty for none. */
export function toldCode({ code }: KeyTelling): string {
  return UNTOLD.test(String(code)) ? "" : code;
}

/** The key's name as the event reports it; empty for none. */
export function toldKey({ key }: KeyTelling): string {
  return UNTOLD.test(String(key)) ? "" : key;
}
