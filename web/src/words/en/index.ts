/** English, the language in which every message is written first: one file an area of the page. */

import face from "./face.json";
import hud from "./hud.json";
import panels from "./panels.json";
import turn from "./turn.json";

export const en = { ...face, ...hud, ...panels, ...turn };
