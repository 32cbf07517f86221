/** English of the parts that are loaded late: it comes with the first of them. */

import door from "./door.json";
import host from "./host.json";
import invitation from "./invitation.json";
import kiosk from "./kiosk.json";
import message from "./message.json";
import own from "./own.json";
import path from "./path.json";
import people from "./people.json";
import proof from "./proof.json";
import rules from "./rules.json";
import stats from "./stats.json";
import ways from "./ways.json";

export const later = {
  ...door,
  ...host,
  ...invitation,
  ...kiosk,
  ...message,
  ...own,
  ...path,
  ...people,
  ...proof,
  ...rules,
  ...stats,
  ...ways,
};
