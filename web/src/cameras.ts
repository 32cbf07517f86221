import { Silence } from "./link/silence";
import type { Look, RoomState, Sentence, StateIn } from "./messages";
import { Playback } from "./playback";
import type { State } from "./state";
import { pageSentence, type Saying } from "./words/said";
import { t } from "./words/words";

/** A camera without a new picture for this long is no longer live. */
const CAMERA_STALE_MS = 2500;

interface Wiring {
  state: State;
  /** Sends over the reliable channel. */
  send(message: StateIn): void;
  /** Shows a sentence to the user. */
  say(what: Saying): void;
  /** Whether this browser reports the frames that it presents. */
  tellsFrames: boolean;
}

/**
 * The cameras other than the driving view: which one is large, and whether they are alive.
 *
 * The driving view is on screen whatever is large. It becomes large again when a turn begins, and
 * when the camera that is large is no longer live.
 */
export class Cameras {
  readonly #playbacks: Playback[] = [];
  /** For each camera, how long it has shown no new picture since it was connected or made large. */
  readonly #silences: Silence[] = [];

  constructor(private readonly wiring: Wiring) {
    const { drivingTurn } = wiring.state;
    let before = drivingTurn.peek();
    drivingTurn.subscribe((turn) => {
      if (turn !== null && before === null) this.choose(null);
      before = turn;
    });
  }

  /** Makes this camera large; null for the driving view. */
  choose(large: number | null): void {
    const { state } = this.wiring;
    if (large === state.large.peek()) return;
    if (large !== null) this.presented(large);
    state.large.value = large;
    this.sendLook();
  }

  /** Makes the next camera large; after the last one, the driving view. */
  next(): void {
    const { state } = this.wiring;
    const count = state.cameras.peek().length;
    const next = (state.large.peek() ?? -1) + 1;
    this.choose(next < count ? next : null);
  }

  /** Tells the server which cameras are shown; called on each new connection and each change. */
  sendLook(): void {
    const { large, cameras, preferences } = this.wiring.state;
    if (cameras.peek().length === 0) return;
    const look: Look = { type: "look", large: large.peek(), small: preferences.peek().cameras };
    this.wiring.send(look);
  }

  /** Plays the cameras of a new connection. */
  setTracks(tracks: readonly MediaStreamTrack[]): void {
    for (const [at, track] of tracks.entries()) {
      this.#playback(at).setTrack(track);
      this.presented(at);
    }
    for (const playback of this.#playbacks.slice(tracks.length)) playback.setTrack(null);
  }

  attach(at: number, element: HTMLVideoElement | null): void {
    this.#playback(at).attach(element);
  }

  /** Restarts a camera's silence: it has shown a picture, or is given time to. */
  presented(at: number): void {
    const nowMs = performance.now();
    this.#silences[at] ??= new Silence(nowMs);
    this.#silences[at].heard(nowMs);
  }

  /** Checks whether each camera is still live; call it a few times a second. */
  checkLive(nowMs: number, isHidden: boolean): void {
    const { state, tellsFrames } = this.wiring;
    const isOff = state.isBlanked.peek() || !state.preferences.peek().picture;
    if (isHidden || isOff || !tellsFrames) {
      for (const silence of this.#silences) silence?.heard(nowMs);
      return;
    }
    for (const silence of this.#silences) silence?.update(nowMs);
    const stale = this.#silences.flatMap(({ quietMs }, at) =>
      quietMs > CAMERA_STALE_MS ? [at] : [],
    );
    const before = state.staleCameras.peek();
    if (stale.join() !== [...before].join()) state.staleCameras.value = new Set(stale);
    const large = state.large.peek();
    if (large === null || !stale.includes(large) || !state.isConnected.peek()) return;
    const name = state.cameras.peek()[large]?.name ?? t("robot.camera_unnamed");
    const isSent = state.served.peek()?.cameras[large] != null;
    this.#comeBack(
      isSent ? t("robot.camera_stands", { name }) : t("robot.camera_not_carried", { name }),
    );
  }

  /** Brings the driving view back if the room reports a problem with the large camera. */
  roomChanged(room: RoomState): void {
    const large = this.wiring.state.large.peek();
    const problem = large === null ? null : room.cameras[large]?.problem;
    if (problem) this.#comeBack(problem);
  }

  #comeBack(why: string | Sentence): void {
    this.choose(null);
    this.wiring.say(pageSentence("robot.camera_back", { why }));
  }

  #playback(at: number): Playback {
    let playback = this.#playbacks[at];
    if (!playback) {
      playback = new Playback();
      playback.play();
      this.#playbacks[at] = playback;
    }
    return playback;
  }
}
