/** German; loaded only when used. */

import type { Catalog, Language } from "../words";
import first from "./first.json";
import later from "./later.json";
import replay from "./replay.json";
import said from "./server.json";

export const de: Catalog = { ...first, ...later, ...replay };

export const german: Language = { tag: "de", direction: "ltr", messages: de, said };
