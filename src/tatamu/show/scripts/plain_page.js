/* Starts a page without a replay. */

import { start } from "./start.js";

start();
