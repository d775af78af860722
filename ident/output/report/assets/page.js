"use strict";
(function () {
  const PAPER = 1000; // Width of a plot on paper [px].
  const templates = JSON.parse(document.getElementById("report-templates").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const button = document.getElementById("theme");
  const waiting = new Map();
  const drawn = [];
  let theme = "";

  function draw(id) {
    const figure = waiting.get(id);
    waiting.delete(id);
    figure.layout.template = templates[theme];
    figure.layout.autosize = true;
    const plot = document.getElementById(id);
    Plotly.newPlot(plot, figure.data, figure.layout, {
      responsive: true,
      displaylogo: false,
      modeBarButtonsToRemove: ["lasso2d", "select2d", "autoScale2d"],
      toImageButtonOptions: { filename: id, scale: 2 },
    });
    drawn.push(plot);
  }

  // Draws one plot at a time, so that the page stays responsive; folded plots are drawn when they are unfolded.
  function drawNext() {
    for (const id of waiting.keys()) {
      if (document.getElementById(id).offsetParent !== null) {
        draw(id);
        setTimeout(drawNext);
        return;
      }
    }
    document.documentElement.dataset.drawn = String(drawn.length);
  }

  function show(name) {
    theme = name;
    document.documentElement.dataset.theme = name;
    button.textContent = name === "dark" ? "Light" : "Dark";
    for (const plot of drawn) Plotly.relayout(plot, { template: templates[name] });
  }

  for (const script of document.querySelectorAll("script[data-figure]")) {
    waiting.set(script.dataset.figure, JSON.parse(script.textContent));
  }
  show(dark.matches ? "dark" : "light");
  drawNext();
  button.addEventListener("click", () => show(theme === "dark" ? "light" : "dark"));
  dark.addEventListener("change", () => show(dark.matches ? "dark" : "light"));
  for (const fold of document.querySelectorAll("details")) {
    fold.addEventListener("toggle", () => {
      drawNext();
      for (const plot of fold.querySelectorAll(".js-plotly-plot")) if (fold.open) Plotly.Plots.resize(plot);
    });
  }

  let before = null;
  window.addEventListener("beforeprint", () => {
    before = { theme, folded: [...document.querySelectorAll("details:not([open])")] };
    for (const fold of before.folded) fold.open = true;
    for (const id of [...waiting.keys()]) draw(id);
    show("light");
    for (const plot of drawn) Plotly.relayout(plot, { width: PAPER });
  });
  window.addEventListener("afterprint", () => {
    if (before === null) return;
    for (const fold of before.folded) fold.open = false;
    for (const plot of drawn) Plotly.relayout(plot, { width: null, autosize: true });
    show(before.theme);
    before = null;
  });
})();
