/** What views get: the state, and what the user can do. */

import type { DrivePreferences } from "./drive/drivePreferences";
import type { PadWish } from "./drive/gamepad";
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
  /** Shows or hides the small pictures of the cameras other than the driving view. */
  setCameras(on: boolean): void;
  /** Makes a camera large, null for the driving view. */
  enlarge(camera: number | null): void;
  setPolicy(policy: Preferences["policy"]): void;
  setPlayer(player: Preferences["player"]): void;
  setName(name: string): void;
  setSpeed(speed: Preferences["speed"]): void;
  /** Chooses the page's language, null for the host's or the browser's. */
  setLanguage(language: Preferences["language"]): void;
  /** Stores preferences that the server need not know. */
  keep(change: Partial<Pick<Preferences, "path" | "welcomed">>): void;
  setAxis(name: string, position: number): void;
  /** Turns the browser's notification of this user's turn on or off; asks for permission first. */
  tellMe(on: boolean): void;
  /** Returns all axes to their middle. */
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
  /** Drives with this gamepad; null for none. */
  useGamepad(index: number | null): void;
  /** Where the gamepad's axes rest if nobody touches it; null unless still for a second. */
  padRestNow(): readonly number[] | null;
  /** Lets the user choose a part of the gamepad in use by pressing it; null ends that. */
  learnPad(wish: PadWish | null): void;
  /** For driving by switches: chooses what is offered, or offers the next. */
  scan(what: "select" | "next"): void;
  join(): void;
  leave(): void;
  /** Stops the robot for everybody; the stop stays in force until it is released. */
  stop(): void;
  /** Releases the stop in force; this moves nothing. */
  releaseStop(): void;
  press(holder: string, held: Held): void;
  /** Moves the stick that this holder still holds; returns false if it holds none any more. */
  deflect(holder: string, motion: Motion): boolean;
  release(holder: string): boolean;
  letGo(): void;
  /** Confirms that this viewer is ready for their turn. */
  answerCall(): void;
  /** Performs one of the host's actions. */
  actAsHost(act: HostAct): void;
  /** Marks the last two minutes of the recording to be kept. */
  keepTape(): void;
  /** Says that the recording of this user's last turn is not to be used. */
  disown(): void;
  /** Says what this user is going to do, for the recording. */
  setTask(text: string): void;
  /** Connects again after the server has sent this page away. */
  comeBack(): void;
  /** Speaks through the robot while any holder holds it. */
  speak(holder: string): void;
  hush(holder: string): void;
  /** Keeps the microphone open without being held, or stops that. */
  keepSpeaking(on: boolean): void;
  /** Opens this panel and closes any other; null closes them all. */
  open(panel: Panel | null): void;
  pollProof(): void;
  prove(): void;
}

export interface Session {
  state: State;
  actions: Actions;
  /** What was measured and what happened in the last minutes. */
  history: History;
  /** Resolves once the first offer was sent; never where there is no connection. */
  offered: Promise<void>;
  /** When the newest picture on screen was captured, on the server's clock; null while unknown. */
  seenServerMs(): number | null;
  /** A camera's element, null for the driving view's, by default the large one's; null for none. */
  shownPicture(camera?: number | null): HTMLVideoElement | null;
  /** Takes a photo of it, in the largest size that the link carries. */
  forPhoto<Taken>(take: () => Promise<Taken>): Promise<Taken>;
  /** Sets the picture's element, null when it is removed. */
  attachPicture(element: HTMLVideoElement | null): void;
  attachSound(element: HTMLAudioElement | null): void;
  /** The driving view's stream, for a second element; null while there is none. */
  pictureStream(): MediaStream | null;
  /** The sound's level now, from 0 to 1: per ear, or of both together; empty if unknown. */
  soundLevels(): Promise<readonly number[]>;
  /** Sets the element of a camera other than the driving view. */
  attachCamera(camera: number, element: HTMLVideoElement | null): void;
}
