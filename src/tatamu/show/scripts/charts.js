/* Plotly's 2-D charts in the colours of the page. A colour "@name" stands for the custom property --name. */

import { packing } from "./packing.js";

const CONFIG = {
  responsive: true,
  displaylogo: false,
  modeBarButtons: [["toImage", "resetScale2d"]],
  toImageButtonOptions: { format: "svg" },
};

/* A copy of a figure's data with its colours filled in; what is named otherwise is no colour. */
function painted(value, key, style) {
  if (typeof value === "string" && value.startsWith("@") && key.endsWith("color")) {
    return style.getPropertyValue(`--${value.slice(1)}`).trim();
  }
  if (Array.isArray(value)) return value.map((item) => painted(item, key, style));
  if (value && typeof value === "object") {
    return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, painted(item, name, style)]));
  }
  return value;
}

/* The layout of a chart with rows in a narrow place: names stand above their rows, not beside them. */
function stacked(layout, names) {
  const rows = [...new Set(names)];
  const above = { xref: "paper", x: 0, xanchor: "left", yshift: 14, showarrow: false };
  return {
    ...layout,
    height: 90 + 36 * rows.length,
    bargap: 0.6,
    margin: { ...layout.margin, l: 8, r: 8 },
    yaxis: { ...layout.yaxis, showticklabels: false, range: [-0.5, rows.length - 0.1] },
    annotations: [...(layout.annotations ?? []), ...rows.map((name) => ({ ...above, y: name, text: name }))],
  };
}

/* Draw every chart of the page; returns how to draw them again when the colours have changed. */
export async function startCharts() {
  const script = document.createElement("script");
  script.textContent = new TextDecoder().decode(await packing.bytes(document.getElementById("plotly").textContent));
  document.head.append(script);
  const figures = JSON.parse(document.getElementById("chart-data").textContent);
  const draw = () => {
    const style = getComputedStyle(document.documentElement);
    for (const [id, figure] of Object.entries(figures)) {
      const { data, layout } = painted(figure, "", style);
      const place = document.getElementById(id);
      const narrow = place.classList.contains("rows") && place.clientWidth < 500;
      Plotly.newPlot(place, data, narrow ? stacked(layout, data[0].y) : layout, CONFIG);
    }
  };
  draw();
  return draw;
}
