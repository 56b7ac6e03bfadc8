"use strict";
(() => {
  const divs = [...document.querySelectorAll(".plot")];
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
  // Colours go into the layout's template, so that repainting leaves the zoom alone.
  const theme = () => {
    const axis = { gridcolor: css("--grid"), linecolor: css("--line"), tickcolor: css("--line") };
    return { template: { layout: {
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      font: { family: "system-ui, sans-serif", size: 12, color: css("--soft") },
      hoverlabel: { bgcolor: css("--card"), bordercolor: css("--line"), font: { color: css("--ink") } },
      modebar: { bgcolor: "rgba(0,0,0,0)", color: css("--line"), activecolor: css("--accent") },
      xaxis: axis, yaxis: axis,
    } } };
  };
  const figures = new Map(divs.map((div) => [div, JSON.parse(div.firstElementChild.textContent)]));
  const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d", "autoScale2d"] };
  for (const [div, figure] of figures) Plotly.newPlot(div, figure.data, { ...figure.layout, ...theme() }, config);

  // Zooming in time zooms the panels of the same section with it.
  let following = false;
  for (const div of divs) {
    div.on("plotly_relayout", (change) => {
      if (following) return;
      const range = [change["xaxis.range[0]"], change["xaxis.range[1]"]];
      const update = change["xaxis.autorange"] ? { "xaxis.autorange": true } : range[0] === undefined ? null : { "xaxis.range": range };
      if (!update) return;
      const others = divs.filter((d) => d !== div && d.dataset.section === div.dataset.section && d.dataset.axis === div.dataset.axis);
      following = true;
      Promise.all(others.map((d) => Plotly.relayout(d, update))).finally(() => { following = false; });
    });
  }

  const repaint = (size) => divs.forEach((div) => Plotly.relayout(div, { ...theme(), ...size }));
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => repaint({}));
  matchMedia("print").addEventListener("change", (query) => {
    if (query.matches) document.querySelectorAll("details:not(.long)").forEach((details) => { details.open = true; });
    repaint(query.matches ? { width: 335, height: 265 } : { width: null, height: null, autosize: true });
  });
})();
