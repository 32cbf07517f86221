/** What views get: the state, and what the user can do. */

import type { DrivePreferences } from "./drive/drivePreferences";
import type { Held, Motion } from "./drive/inputState";
import type { HostAct } from "./messages";
import type { Preferences } from "./preferences";
import type { HearingActions } from "./sound/hearing";
import type { Panel, State } from "./state";
import type { History } from "./stats/history";

/** The user's actions. */
export interface Actions extends HearingActions {
  start(): void;
  setSound(on: boolean): void;
  setPicture(on: boolean): void;
  setSize(size: string): void;
  /** Shows the cameras beside the driving view small, or not. */
  setCameras(on: boolean): void;
  /** Makes a camera large, null for the driving view. */
  enlarge(camera: number | null): void;
  setPolicy(policy: Preferences["policy"]): void;
  setPlayer(player: Preferences["player"]): void;
  setName(name: string): void;
  setSpeed(speed: Preferences["speed"]): void;
  /** Chooses the page's language, null for the host's or the browser's. */
  setLanguage(language: Preferences["language"]): void;
  /** Remembers on this device what matters to this page alone. */
  keep(change: Partial<Pick<Preferences, "path" | "welcomed">>): void;
  setAxis(name: string, position: number): void;
  /** Has the browser tell when it is this user's turn, if it lets the page, or no more. */
  tellMe(on: boolean): void;
  /** Brings all axes back to their middle. */
  recentre(): void;
  /** Holds one of the robot's controls, until the same holder releases it. */
  holdControl(holder: string, name: string): void;
  /** Returns false if this holder held none. */
  releaseControl(holder: string): boolean;
  slideControl(name: string, value: number): void;
  setControl(name: string, value: number): void;
  toggleControl(name: string): void;
  /** Changes how this user drives, which releases everything. */
  setDriving(change: Partial<DrivePreferences>): void;
  /** Drives with this gamepad, with none for null. */
  useGamepad(index: number | null): void;
  /** Where its axes rest, if nobody touches it now; null unless they stood still for a second. */
  padRestNow(): readonly number[] | null;
  /** Chooses what is offered to somebody with switches, or moves on. */
  scan(what: "select" | "next"): void;
  join(): void;
  leave(): void;
  /** Stop for everybody, latched. */
  stop(): void;
  /** Releases the stop in force; this moves nothing. */
  releaseStop(): void;
  press(holder: string, held: Held): void;
  /** Moves the stick that this holder still holds; returns false if it holds none any more. */
  deflect(holder: string, motion: Motion): boolean;
  release(holder: string): boolean;
  letGo(): void;
  /** Answers the question whether somebody is there. */
  answerCall(): void;
  /** Does what only the host may. */
  actAsHost(act: HostAct): void;
  /** Keeps what was recorded in the last two minutes. */
  keepTape(): void;
  /** Tries again to come in, after the server has sent this page away. */
  comeBack(): void;
  /** Speaks through the robot while any holder holds it. */
  speak(holder: string): void;
  hush(holder: string): void;
  /** Keeps the microphone open, or ends that. */
  keepSpeaking(on: boolean): void;
  /** Opens a panel in place of the one that is open; null for none. */
  open(panel: Panel | null): void;
  lookAtProof(): void;
  prove(): void;
}

export interface Session {
  state: State;
  actions: Actions;
  /** What was measured and what happened in the last minutes. */
  history: History;
  /** Resolves once the first offer was sent; never where there is no connection. */
  offered: Promise<void>;
  /** The element of the picture that is large, null while there is none. */
  shownPicture(): HTMLVideoElement | null;
  /** Sets the picture's element, null when it is removed. */
  attachPicture(element: HTMLVideoElement | null): void;
  attachSound(element: HTMLAudioElement | null): void;
  /** The driving view, to be shown once more; null while there is none. */
  pictureStream(): MediaStream | null;
  /** How loud the sound is now, from 0 to 1: of each ear, or of both together; none if unknown. */
  soundLevels(): Promise<readonly number[]>;
  /** Sets the element of a camera beside the driving view. */
  attachCamera(camera: number, element: HTMLVideoElement | null): void;
}
