/* The replay of a page: its data, its viewer, its controls. */

import { Motion } from "./motion.js";
import { Player } from "./player.js";
import { Viewer } from "./viewer.js";

/* Show it, or say why not; returns how to draw it again when the colours have changed. */
export async function startReplay() {
  const root = document.getElementById("replay");
  try {
    const data = JSON.parse(document.getElementById("replay-data").textContent);
    const robot = data.robot && (await Motion.unpack({ ...data.robot, times: data.times, hands: [] }));
    const viewer = new Viewer(root.querySelector("canvas"), await Motion.unpack(data), data, robot);
    const player = new Player(viewer, root);
    openAt(player);
    /* For scripts and tests: go to a time [s]; what is being drawn. */
    window.tatamu.seek = (time) => player.hold(time);
    window.tatamu.state = () => ({
      time: viewer.time,
      centroid: viewer.motion.centroid(),
      draws: viewer.draws,
      running: player.running,
    });
    return () => viewer.recolour();
  } catch (error) {
    root.dataset.failed = "true";
    root.querySelector("[data-part=failure]").textContent = `The replay cannot be shown here (${error.message}).`;
    return () => {};
  }
}

/* `report.html#t=1.5` opens at 1.5 s, at rest; otherwise the fold plays once, unless the reader wants less motion. */
function openAt(player) {
  const asked = /[#&]t=([\d.]+)/.exec(location.hash);
  if (asked) player.hold(Number(asked[1]));
  else if (matchMedia("(prefers-reduced-motion: reduce)").matches) player.hold(0.4 * player.duration);
  else player.play();
}
