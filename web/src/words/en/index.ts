/** Every message, as English writes it: what other languages translate. */

import first from "./first.json";
import later from "./later.json";
import replay from "./replay.json";

export const all = { ...first, ...later, ...replay };
