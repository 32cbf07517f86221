/** German; loaded only for who reads it. */

import type { Catalog } from "../words";
import face from "./face.json";
import hud from "./hud.json";
import panels from "./panels.json";
import turn from "./turn.json";

export const de: Catalog = { ...face, ...hud, ...panels, ...turn };
