import type { Direction, InputState } from "./inputState";

const DIRECTIONS: Record<string, Direction> = {
  ArrowUp: "forward",
  ArrowDown: "back",
  ArrowLeft: "left",
  ArrowRight: "right",
  // By position, not by letter: on a French keyboard these are Z, Q, S, D.
  KeyW: "forward",
  KeyS: "back",
  KeyA: "left",
  KeyD: "right",
};

const TYPING = "textarea, select, [contenteditable], input:not([type=checkbox])";
const OPERABLE = `${TYPING}, button, a[href], summary, input`;

export interface KeyboardOptions {
  input: InputState;
  isDriving: () => boolean;
  /** The operator's Stop, on Space. */
  stop: () => void;
  /** Releases everything at once. */
  letGo: () => void;
  signal: AbortSignal;
}

/** Drives by arrow keys and WASD, and stops by Space, unless a text field has the focus. */
export function listenKeyboard(
  target: EventTarget,
  { input, isDriving, stop, letGo, signal }: KeyboardOptions,
): void {
  // Not every browser marks repeated keys as such after the window lost the focus.
  const down = new Set<string>();

  const onDown = (event: KeyboardEvent) => {
    const repeated = event.repeat || down.has(event.code);
    down.add(event.code);
    if (event.ctrlKey || event.metaKey || event.altKey) {
      // macOS sends no keyup while Meta is down.
      letGo();
      return;
    }
    if (!isDriving()) return;
    const focus = event.target instanceof Element ? event.target : null;
    const direction = DIRECTIONS[event.code];
    if (direction && !focus?.closest(TYPING)) {
      event.preventDefault();
      if (!repeated) input.press(`key ${event.code}`, direction);
    } else if (event.code === "Space" && !focus?.closest(OPERABLE)) {
      event.preventDefault();
      if (!repeated) stop();
    }
  };

  const onUp = (event: KeyboardEvent) => {
    down.delete(event.code);
    input.release(`key ${event.code}`);
  };

  const options = { signal };
  target.addEventListener("keydown", onDown as EventListener, options);
  target.addEventListener("keyup", onUp as EventListener, options);
  target.addEventListener("blur", () => down.clear(), options);
}
