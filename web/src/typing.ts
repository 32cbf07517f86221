/** Which key presses are the page's, not a text field's; keys that drive: `drive/keyboard.ts`. */

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

/** Whether a press is a key's own act: not typing, not repeated, and no shortcut of the browser. */
export function isOwnPress(event: KeyboardEvent): boolean {
  if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return false;
  return !(event.target instanceof Element && event.target.closest(TYPING));
}
