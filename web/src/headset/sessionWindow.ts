/** A headset's session as a window, so that whatever hides one lets go as a hidden tab does. */

/** Without a drawn frame for this long, whoever wears the headset does not see the robot. */
const UNDRAWN_MS = 150;

class SessionDocument extends EventTarget {
  constructor(private readonly isSeen: () => boolean) {
    super();
  }

  get hidden(): boolean {
    return !this.isSeen();
  }

  get visibilityState(): DocumentVisibilityState {
    return this.hidden ? "hidden" : "visible";
  }

  hasFocus(): boolean {
    return this.isSeen();
  }
}

/**
 * What `letGo.ts` and `gamepad.ts` need of a window. It is hidden while the session is not "visible":
 * taken off, below the system's menu or a dialog of the guardian; and while nothing is drawn.
 */
export class SessionWindow extends EventTarget {
  readonly document = new SessionDocument(() => this.#isSeen());
  readonly navigator: { getGamepads: () => unknown[] };
  #drawnMs = Number.NEGATIVE_INFINITY;

  constructor(
    private readonly session: Pick<XRSession, "visibilityState" | "addEventListener">,
    pad: () => object,
  ) {
    super();
    // The pad stays in its place: a hand that is gone holds nothing.
    this.navigator = { getGamepads: () => [{ ...pad(), index: 0, connected: true }] };
    session.addEventListener("visibilitychange", () => {
      this.document.dispatchEvent(new Event("visibilitychange"));
    });
    session.addEventListener("end", () => {
      this.#drawnMs = Number.NEGATIVE_INFINITY;
      this.dispatchEvent(new Event("pagehide"));
    });
  }

  /** As those modules take it, which use no more of it than this class has. */
  get asWindow(): Window {
    return this as unknown as Window;
  }

  drawn(): void {
    this.#drawnMs = performance.now();
  }

  #isSeen(): boolean {
    const isLate = performance.now() - this.#drawnMs > UNDRAWN_MS;
    return this.session.visibilityState === "visible" && !isLate;
  }
}
