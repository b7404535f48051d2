/* Bring a page to life: its copy buttons, its charts, and the replay where it has one. */

import { startCharts } from "./charts.js";

function startCopying() {
  document.querySelectorAll("[data-copy]").forEach((button) =>
    button.addEventListener("click", async () => {
      const code = document.getElementById(button.dataset.copy);
      try {
        await navigator.clipboard.writeText(code.textContent);
        button.textContent = "Copied";
      } catch {
        getSelection().selectAllChildren(code);
        button.textContent = "Selected";
      }
      setTimeout(() => (button.textContent = "Copy"), 1500);
    }));
}

async function startAll(parts) {
  startCopying();
  const redraws = [];
  for (const part of parts) redraws.push(await part());
  const dark = matchMedia("(prefers-color-scheme: dark)");
  dark.addEventListener("change", () => redraws.forEach((redraw) => redraw()));
}

/* Start the page with other parts, such as the replay, before its charts; `tatamu.ready` is when all is drawn. */
export function start(...others) {
  const charts = document.getElementById("plotly") ? [startCharts] : [];
  window.tatamu = {};
  window.tatamu.ready = startAll([...others, ...charts]);
}
