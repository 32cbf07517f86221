/** What is printed on a key. */

import { signal } from "@preact/signals";
import { SHIFT, withoutShift } from "./keyMap";

/** Chromium only. */
interface KeyboardNavigator {
  keyboard?: { getLayoutMap?: () => Promise<ReadonlyMap<string, string>> };
}

/** What this keyboard has on its keys, as far as the browser tells. */
const printed = signal<ReadonlyMap<string, string>>(new Map());

/** Asks the browser once; where it does not tell, keys are named as most keyboards have them. */
export async function readKeyCaps({ keyboard }: KeyboardNavigator): Promise<void> {
  try {
    printed.value = (await keyboard?.getLayoutMap?.()) ?? printed.value;
  } catch {
    // A frame on another site may not know.
  }
}

const ARROWS: Record<string, string> = {
  ArrowUp: "↑",
  ArrowDown: "↓",
  ArrowLeft: "←",
  ArrowRight: "→",
};

export function keyWords(key: string): string {
  if (key.startsWith(SHIFT)) return SHIFT + keyWords(withoutShift(key));
  return (
    ARROWS[key] ??
    printed.value.get(key)?.toUpperCase() ??
    key.replace(/^(Key|Digit)(?=.$)/, "").replace(/(?<=[a-z])(?=[A-Z0-9])/, " ")
  );
}
