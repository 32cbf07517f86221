/** The message types, made from the server's models by `npm run types`. */
export type * from "./generated/messages";
/** What stands where in a row, and as many characters of a name as the server keeps. */
export { DRIVE_COLUMNS, MAX_NAME_CHARS } from "./generated/messages";

import type { Messages } from "./generated/messages";

export type DriveIn = Messages["DriveIn"];
export type DriveOut = Messages["DriveOut"];
export type StateIn = Messages["StateIn"];
export type StateOut = Messages["StateOut"];

/** The two data channels, both opened by the page. */
export type Channel = "drive" | "state";
