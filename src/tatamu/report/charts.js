/* Plotly's 2-D figures in the colours of the page. A colour "@name" stands for the custom property --name. */

class Charts {
  constructor(figures) {
    this.figures = figures;
    this.draw();
  }

  draw() {
    const style = getComputedStyle(document.documentElement);
    const paint = (value, key) => {
      if (typeof value === "string" && value.startsWith("@") && key.endsWith("color")) {
        return style.getPropertyValue(`--${value.slice(1)}`).trim();
      }
      if (Array.isArray(value)) return value.map((item) => paint(item, key));
      if (value && typeof value === "object") {
        return Object.fromEntries(Object.entries(value).map(([name, item]) => [name, paint(item, name)]));
      }
      return value;
    };
    const config = {
      responsive: true,
      displaylogo: false,
      modeBarButtons: [["toImage", "resetScale2d"]],
      toImageButtonOptions: { format: "svg" },
    };
    for (const [id, figure] of Object.entries(this.figures)) {
      const { data, layout } = paint(figure, "");
      Plotly.react(document.getElementById(id), data, layout, config);
    }
  }
}
