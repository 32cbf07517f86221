/** For every test: all words are there, as soon after the page's first picture. */
import { all } from "../words/en";
import { loadSaid } from "../words/said";
import { learn } from "../words/words";

learn(all);
await loadSaid();
