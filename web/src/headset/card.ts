/** The card below the picture: turn, seconds, what to do or what limits, and delay. */

import type { State } from "../state";
import { faceOf, type Tone } from "../view/face";
import { msWords } from "../view/figures";
import { isUndated } from "../view/pageWords";
import { said } from "../words/said";
import { figure, t } from "../words/words";

export interface CardWords {
  tone: Tone;
  headline: string;
  left: string;
  next: string;
  figures: string;
}

/** What the controllers say of themselves. */
export interface Grip {
  /** Whether there is a controller that can drive. */
  isThere: boolean;
  isSqueezed: boolean;
  /** Whether the sticks move the robot: once they rested since the squeeze. */
  isReady: boolean;
}

/** The words of the card; reads signals. */
export function cardWords(state: State, grip: Grip): CardWords {
  const face = faceOf(state);
  const seconds = state.isConnected.value ? state.secondsLeft.value : null;
  return {
    tone: face.tone,
    headline: face.headline,
    left: face.wait ?? (seconds === null ? "" : t("face.left", { n: seconds })),
    next: next(state, grip) ?? face.next,
    figures: figures(state),
  };
}

function next(state: State, { isThere, isSqueezed, isReady }: Grip): string | null {
  const answerIn = state.callSecondsLeft.value;
  if (answerIn !== null) return t("headset.answer", { seconds: answerIn });
  if (state.stopNumber.value !== null) return state.mayRelease.value ? t("headset.release") : null;
  if (state.drivingTurn.value === null) return null;
  if (!isThere) return t("headset.no_controller");
  if (isSqueezed && !isReady) return t("headset.let_go");
  return state.isHolding.value ? said(state.driveReason.value) : t("headset.squeeze");
}

function figures({ facts, room, isSilent, preferences, drivingTurn, driveShare }: State): string {
  const { pictureMs, soundMs } = facts.value;
  const isUnknown = isSilent.value || isUndated(room.value);
  const ageMs = isUnknown ? null : (pictureMs ?? soundMs);
  const delay = `${t("hud.delay")} ${msWords(ageMs === null ? null : Math.max(0, ageMs))}`;
  if (drivingTurn.value === null) return delay;
  const speed = t(preferences.value.speed === "fast" ? "drive.fast" : "drive.slow");
  const share = driveShare.value;
  // At 0 the robot is held, and the line above says why.
  const limit = share > 0 && share < 1 ? ` · ${figure(Math.round(share * 100))} %` : "";
  return `${delay} · ${speed}${limit}`;
}

export const CARD = { width: 1024, height: 288 } as const;
const MARGIN = 32;
const FONT = "system-ui, sans-serif";
const COLOURS: Readonly<Record<Tone, string>> = {
  connecting: "#26303a",
  calm: "#26303a",
  driving: "#14532d",
  ending: "#7c2d12",
  stopped: "#991b1b",
  trouble: "#7c2d12",
};

/** Draws the words on a canvas of the size `CARD`. */
export function paint(canvas: CanvasRenderingContext2D, words: CardWords): void {
  const inner = CARD.width - 2 * MARGIN;
  const line = (text: string, y: number, font: string, within = inner) => {
    canvas.font = `${font} ${FONT}`;
    canvas.fillText(text, MARGIN, y, within);
  };
  canvas.fillStyle = COLOURS[words.tone];
  canvas.fillRect(0, 0, CARD.width, CARD.height);
  canvas.fillStyle = "#fff";
  canvas.textBaseline = "alphabetic";
  canvas.font = `600 52px ${FONT}`;
  const left = canvas.measureText(words.left).width;
  canvas.fillText(words.left, CARD.width - MARGIN - left, 76);
  line(words.headline, 76, "600 52px", inner - left - MARGIN);
  canvas.font = `36px ${FONT}`;
  const [first = "", rest = ""] = inTwo(
    words.next,
    (text) => canvas.measureText(text).width,
    inner,
  );
  line(first, 142, "36px");
  line(rest, 188, "36px");
  line(words.figures, 254, "36px");
}

/** Breaks a text that is wider than `width` after the last word that fits. Pure. */
export function inTwo(text: string, widthOf: (text: string) => number, width: number): string[] {
  if (widthOf(text) <= width) return [text];
  const words = text.split(" ");
  let fitting = Math.max(1, words.length - 1);
  while (fitting > 1 && widthOf(words.slice(0, fitting).join(" ")) > width) fitting--;
  return [words.slice(0, fitting).join(" "), words.slice(fitting).join(" ")];
}
