/** For every test: the server's words are there, as soon after the page's first picture. */
import { loadSaid } from "../words/said";

await loadSaid();
