/** English, as far as the first load says it: one file an area of the page. */

import aboard from "./aboard.json";
import controls from "./controls.json";
import drive from "./drive.json";
import entry from "./entry.json";
import face from "./face.json";
import facts from "./facts.json";
import figures from "./figures.json";
import host from "./host.json";
import hud from "./hud.json";
import kiosk from "./kiosk.json";
import language from "./language.json";
import late from "./late.json";
import link from "./link.json";
import message from "./message.json";
import own from "./own.json";
import panels from "./panels.json";
import queue from "./queue.json";
import robot from "./robot.json";
import sound from "./sound.json";
import stage from "./stage.json";
import stats from "./stats.json";
import stop from "./stop.json";
import support from "./support.json";
import tape from "./tape.json";
import turn from "./turn.json";
import voice from "./voice.json";
import watch from "./watch.json";
import ways from "./ways.json";
import when from "./when.json";

export const en = {
  ...aboard,
  ...controls,
  ...drive,
  ...entry,
  ...face,
  ...facts,
  ...figures,
  ...host,
  ...hud,
  ...kiosk,
  ...language,
  ...late,
  ...link,
  ...message,
  ...own,
  ...panels,
  ...queue,
  ...robot,
  ...sound,
  ...stage,
  ...stats,
  ...stop,
  ...support,
  ...tape,
  ...turn,
  ...voice,
  ...watch,
  ...ways,
  ...when,
};
