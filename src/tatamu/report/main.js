/* Bring the page to life: the replay, the charts, the copy buttons. */

const contents = (id) => JSON.parse(document.getElementById(id).textContent);

async function startReplay() {
  const root = document.getElementById("replay");
  try {
    const data = contents("replay-data");
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

async function startCharts() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await packing.bytes(document.getElementById("plotly").textContent));
  document.head.append(script);
  return new Charts(contents("chart-data"));
}

/* `report.html#t=1.5` opens at 1.5 s, at rest; otherwise the fold plays once, unless the reader wants less motion. */
function openAt(player) {
  const asked = /[#&]t=([\d.]+)/.exec(location.hash);
  if (asked) player.hold(Number(asked[1]));
  else if (matchMedia("(prefers-reduced-motion: reduce)").matches) player.hold(0.4 * player.duration);
  else player.play();
}

function startCopying() {
  document.querySelectorAll("[data-copy]").forEach((button) =>
    button.addEventListener("click", async () => {
      const text = document.getElementById(button.dataset.copy).textContent;
      try {
        await navigator.clipboard.writeText(text);
        button.textContent = "Copied";
      } catch {
        getSelection().selectAllChildren(document.getElementById(button.dataset.copy));
        button.textContent = "Selected";
      }
      setTimeout(() => (button.textContent = "Copy"), 1500);
    }));
}

async function start() {
  startCopying();
  const recolourReplay = await startReplay();
  const charts = document.getElementById("plotly") && (await startCharts());
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
    recolourReplay();
    charts?.draw();
  });
}

window.tatamu = {};
window.tatamu.ready = start();
