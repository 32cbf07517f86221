/**
 * The robot in a headset, by WebXR: one more view over the same input and the same picture, loaded
 * only where there is a headset. The head does not move the robot.
 *
 * Chromium presents a video's frames to its callbacks while a session runs, though it calls those of
 * the window's animation no more (WICG/video-rvfc#58, since Chromium 87). So the page still reports
 * what was presented, and exactly these frames are drawn here.
 */

import { effect, signal } from "@preact/signals";
import type { Session } from "../actions";
import { tellsFrames, watchFrames } from "../measure/picture";
import { isLive } from "../view/live";
import { within } from "../within";
import { CARD, cardWords, paint } from "./card";
import { listenHands } from "./listenHands";
import { halfHeightDeg, meshOf } from "./mesh";
import { Scene, Sheet } from "./scene";

/** The session that runs; null while there is none. */
export const inHeadset = signal<XRSession | null>(null);

/** Where eyes rest: headsets focus between 1.3 and 2 m. */
const DISTANCE_M = 2;
/** Of a picture whose field of view is unknown. */
const ACROSS_DEG = 60;
const BESIDE_DEG = 30;
const CARD_DEG = 40;
const GAP_DEG = 2;
/** Lower, or farther aside, it would take more than the eyes to look there. */
const LOWEST_DEG = 28;

/** Enters; must be called in a click. Throws what the browser answers if it does not let us. */
export async function enterHeadset(page: Session, xr: XRSystem): Promise<void> {
  const session = await xr.requestSession("immersive-vr");
  let isOver = false;
  session.addEventListener("end", () => {
    isOver = true;
  });
  try {
    const asking = session.requestReferenceSpace("local");
    const space = await within("XRSession.requestReferenceSpace", asking);
    if (isOver) throw new Error("the session has ended");
    run(page, session, space);
    inHeadset.value = session;
  } catch (error) {
    void session.end().catch(() => {});
    throw error;
  }
}

function run(page: Session, session: XRSession, space: XRReferenceSpace): void {
  const { state } = page;
  const gl = document.createElement("canvas").getContext("webgl", {
    xrCompatible: true,
    antialias: false, // the session's layer has smooth edges of its own
  });
  if (!gl) throw new Error("no WebGL");
  const layer = new XRWebGLLayer(session, gl);
  const scene = new Scene(gl);
  void session.updateRenderState({ baseLayer: layer });
  const ending = new AbortController();
  const { signal: ended } = ending;

  const { seen, grip, frame: follow } = listenHands(page, session, ended);
  session.addEventListener("end", () => {
    inHeadset.value = null;
    ending.abort();
  });
  const sheets = [new Sheet(gl), new Sheet(gl), new Sheet(gl)] as const;
  const [driving, beside, card] = sheets;
  const films = { driving: new Film(driving), beside: new Film(beside) };

  const canvas = Object.assign(document.createElement("canvas"), CARD).getContext("2d");
  let painted = "";
  const unwatch = effect(() => {
    const words = cardWords(state, grip.value);
    if (!canvas || JSON.stringify(words) === painted) return;
    painted = JSON.stringify(words);
    paint(canvas, words);
    card.show(canvas.canvas);
  });
  ended.addEventListener("abort", unwatch);

  let arranged = "";
  const arrange = (aspect: number | null, asideAspect: number | null) => {
    const { camera, camera_stereo: isPair } = state.hello.peek()?.robot ?? {};
    const key = JSON.stringify([aspect, asideAspect, camera, isPair]);
    if (key === arranged) return;
    arranged = key;
    driving.isPair = isPair === true;
    const main = {
      acrossDeg: camera?.fov_deg ?? ACROSS_DEG,
      aspect: ((aspect ?? 4 / 3) * (isPair ? 1 : 2)) / 2,
      distanceM: DISTANCE_M,
      isCurved: camera !== undefined && camera !== null,
    };
    driving.shape(aspect === null ? null : meshOf(main));
    const side = { acrossDeg: BESIDE_DEG, distanceM: DISTANCE_M, isCurved: false };
    const yawDeg = Math.min(main.acrossDeg, 90) / 2 + GAP_DEG + BESIDE_DEG / 2;
    beside.shape(asideAspect === null ? null : meshOf({ ...side, aspect: asideAspect, yawDeg }));
    const words = { ...side, acrossDeg: CARD_DEG, aspect: CARD.width / CARD.height };
    const below = Math.min(halfHeightDeg(main), LOWEST_DEG) + GAP_DEG + halfHeightDeg(words);
    card.shape(meshOf({ ...words, pitchDeg: -below }));
  };

  const onFrame: XRFrameRequestCallback = (_, frame) => {
    session.requestAnimationFrame(onFrame);
    follow();
    const { preferences, large, staleCameras, cameras, isBlanked } = state;
    const isShown = preferences.peek().picture && !isBlanked.peek();
    const other = large.peek() ?? 0;
    const hasOther = other < cameras.peek().length && (preferences.peek().cameras || large.peek());
    const aspect = films.driving.follow(isShown ? page.shownPicture(null) : null);
    const aside = films.beside.follow(isShown && hasOther ? page.shownPicture(other) : null);
    arrange(aspect, aside);
    driving.isLive = isLive(state);
    beside.isLive = !staleCameras.peek().has(other);
    const pose = frame.getViewerPose(space);
    // Nothing is seen now; after a moment of it nothing is held (`sessionWindow.ts`).
    if (!pose || gl.isContextLost()) return;
    scene.draw(layer, pose.views, sheets);
    seen.drawn();
  };
  const end = () => void session.end().catch(() => {});
  gl.canvas.addEventListener("webglcontextlost", end, { signal: ended });
  ended.addEventListener(
    "abort",
    state.ended.subscribe((why) => why && end()),
  );
  ended.addEventListener("abort", () => {
    for (const film of Object.values(films)) film.follow(null);
  });
  session.requestAnimationFrame(onFrame);
}

/** Keeps on a sheet what a video element presents, frame by frame. */
class Film {
  #video: HTMLVideoElement | null = null;
  #isNew = false;
  #unwatch = () => {};

  constructor(private readonly sheet: Sheet) {}

  /** Returns the picture's width by its height; null while there is none. */
  follow(video: HTMLVideoElement | null): number | null {
    if (video !== this.#video) {
      this.#unwatch();
      this.#video = video;
      this.#isNew = true;
      const presented = () => {
        this.#isNew = true;
      };
      this.#unwatch = video ? watchFrames(video, { presented }, () => undefined) : () => {};
    }
    if (!video || video.videoWidth === 0) return null;
    // Where a browser does not tell, each of its frames may be new.
    if (this.#isNew || !tellsFrames()) this.sheet.show(video);
    this.#isNew = false;
    return video.videoWidth / video.videoHeight;
  }
}
