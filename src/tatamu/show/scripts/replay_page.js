/* Starts a page with a replay. */

import { startReplay } from "./replay.js";
import { start } from "./start.js";

start(startReplay);
