/** German; loaded only for who reads it. */

import type { Catalog } from "../words";
import turn from "./turn.json";

export const de: Catalog = { ...turn };
