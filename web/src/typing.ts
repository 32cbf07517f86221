/** Which key presses are for the page, not a text field; keys that drive: `drive/keyboard.ts`. */

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox], [type=range])";

/** Whether a press is meant for the page: not typing, not a repeat, not a browser shortcut. */
export function isOwnPress(event: KeyboardEvent): boolean {
  if (event.repeat || event.ctrlKey || event.metaKey || event.altKey) return false;
  return !(event.target instanceof Element && event.target.closest(TYPING));
}
