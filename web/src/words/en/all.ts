/** Every message, as English writes it first: what other languages translate. */

import { en } from ".";
import { later } from "./later";
import replay from "./replay.json";

export const all = { ...en, ...later, ...replay };
