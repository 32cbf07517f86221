/** German; loaded only for who reads it. */

import type { Catalog } from "../words";
import aboard from "./aboard.json";
import entry from "./entry.json";
import face from "./face.json";
import figures from "./figures.json";
import host from "./host.json";
import hud from "./hud.json";
import language from "./language.json";
import link from "./link.json";
import panels from "./panels.json";
import queue from "./queue.json";
import robot from "./robot.json";
import rules from "./rules.json";
import sound from "./sound.json";
import stop from "./stop.json";
import turn from "./turn.json";
import voice from "./voice.json";
import when from "./when.json";

export const de: Catalog = {
  ...aboard,
  ...entry,
  ...face,
  ...figures,
  ...host,
  ...hud,
  ...language,
  ...link,
  ...panels,
  ...queue,
  ...robot,
  ...rules,
  ...sound,
  ...stop,
  ...turn,
  ...voice,
  ...when,
};
