/* A page of figures and tables without a replay. */

async function start() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await packing.bytes(document.getElementById("plotly").textContent));
  document.head.append(script);
  const charts = new Charts(JSON.parse(document.getElementById("chart-data").textContent));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => charts.draw());
}

window.tatamu = {};
window.tatamu.ready = start();
