/** The message types, generated from the server's models by `npm run types`. */
export type * from "./generated/messages";
/**
 * The columns of the drive channel's rows, the longest name and task that the server accepts, and
 * how the robot's numbers are shown.
 */
export { DRIVE_COLUMNS, MAX_NAME_CHARS, MAX_TASK_CHARS, ROBOT_NUMBERS } from "./generated/messages";

import type {
  Disown,
  Follow,
  Here,
  Join,
  KeepTape,
  Leave,
  Look,
  Messages,
  Received,
  Release,
  SetName,
  SetTask,
  Stop,
  Want,
} from "./generated/messages";

export type DriveIn = Messages["DriveIn"];
export type DriveOut = Messages["DriveOut"];
export type StateIn = Messages["StateIn"];
/** What only the host sends. */
export type HostAct = Exclude<
  StateIn,
  | SetName
  | Join
  | Leave
  | Here
  | Stop
  | Release
  | Want
  | Look
  | KeepTape
  | SetTask
  | Disown
  | Follow
  | Received
>;
export type StateOut = Messages["StateOut"];
/** What the page posts, by path. */
export type Bodies = Messages["Bodies"];
/** What the server answers, by path, if it does what was asked. */
export type Answers = Messages["Answers"];

/** The two data channels, both opened by the page. */
export type Channel = "drive" | "state";
