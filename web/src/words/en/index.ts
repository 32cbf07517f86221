/** English, the language in which every message is written first: one file an area of the page. */

import turn from "./turn.json";

export const en = { ...turn };
