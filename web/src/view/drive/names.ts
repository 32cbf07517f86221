/** The names of the ways to drive, and their numbers in words. */

import type { Refusal } from "../../drive/assignKey";
import type { Direction } from "../../drive/inputState";
import type { KeyAction } from "../../drive/keyMap";
import type { Way } from "../../drive/ways";
import { type Code, language } from "../../words/words";

export const WAY_NAMES: Record<Way, readonly [name: Code, help: Code]> = {
  hold: ["ways.way_hold", "ways.way_hold_help"],
  step: ["ways.way_step", "ways.way_step_help"],
  click: ["ways.way_click", "ways.way_click_help"],
  scan: ["ways.way_scan", "ways.way_scan_help"],
};

export const ACTION_NAMES: Record<Exclude<KeyAction, Direction>, Code> = {
  stop: "stop.stop",
  speed: "ways.do_speed",
  axis1_plus: "ways.do_axis1_plus",
  axis1_minus: "ways.do_axis1_minus",
  axis2_plus: "ways.do_axis2_plus",
  axis2_minus: "ways.do_axis2_minus",
  recentre: "ways.recentre",
  talk: "ways.do_talk",
  cameras: "ways.do_cameras",
  mute: "ways.do_mute",
  scan_select: "ways.do_scan_select",
  scan_next: "ways.do_scan_next",
};

export const REFUSALS: Record<Refusal["why"], Code> = {
  reserved: "ways.keys_reserved",
  taken: "ways.keys_taken",
  too_many: "ways.keys_too_many",
  always_stops: "ways.keys_always_stops",
};

export function seconds(ms: number): string {
  return written(ms / 1000, { style: "unit", unit: "second", unitDisplay: "short" });
}

export function percent(share: number): string {
  return written(share, { style: "percent" });
}

/** A number as the reader's language writes it. */
export function written(value: number, how?: Intl.NumberFormatOptions): string {
  return value.toLocaleString(language.value.tag, how);
}
