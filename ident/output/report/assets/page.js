"use strict";
(function () {
  const PAPER = 700; // Width of a plot on A4 [px].
  const PAPER_SHARE = 0.66; // Height of a plot on paper, as a share of that on a screen.
  const PAPER_LEAST = 260; // No plot becomes lower than this [px].
  const PAPER_FONT = 9; // Size of all letters in it [px].
  const templates = JSON.parse(document.getElementById("report-templates").textContent);
  const dark = window.matchMedia("(prefers-color-scheme: dark)");
  const { copy, narrow, stacked, belowLegend } = figuresOnNarrowPages;
  const button = document.getElementById("theme");
  const contents = document.getElementById("contents");
  const waiting = new Map();
  const drawn = new Map();
  let theme = "";

  function smallPrint(template) {
    const small = copy(template);
    const { font, xaxis, yaxis } = small.layout;
    for (const each of [font, xaxis.tickfont, xaxis.title.font, yaxis.tickfont, yaxis.title.font]) each.size = PAPER_FONT;
    return small;
  }

  function layoutOf(id, paper) {
    const original = drawn.get(id).layout;
    const layout = narrow.matches && !paper ? stacked(original) : copy(original);
    layout.template = paper ? smallPrint(templates[theme]) : templates[theme];
    if (paper) {
      layout.width = PAPER;
      layout.height = Math.round(Math.max(PAPER_SHARE * layout.height, Math.min(layout.height, PAPER_LEAST)));
    } else {
      layout.autosize = true;
    }
    return layout;
  }

  function redraw(id, paper) {
    const plot = document.getElementById(id);
    const layout = layoutOf(id, paper);
    plot.style.height = layout.height + "px";
    Plotly.react(plot, plot.data, layout).then(() => belowLegend(Plotly, plot));
  }

  function draw(id, paper) {
    const figure = waiting.get(id);
    waiting.delete(id);
    drawn.set(id, figure);
    const plot = document.getElementById(id);
    const whole = (figure.layout.meta || {}).whole;
    const layout = layoutOf(id, paper);
    plot.style.height = layout.height + "px";
    Plotly.newPlot(plot, figure.data, layout, {
      responsive: true,
      displaylogo: false,
      doubleClick: whole ? "autosize" : "reset+autosize",
      modeBarButtonsToRemove: ["lasso2d", "select2d", whole ? "resetScale2d" : "autoScale2d"],
      toImageButtonOptions: { filename: id, scale: 2 },
    }).then(() => belowLegend(Plotly, plot));
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
    document.documentElement.dataset.drawn = String(drawn.size);
  }

  function show(name) {
    theme = name;
    document.documentElement.dataset.theme = name;
    button.textContent = name === "dark" ? "Light" : "Dark";
    for (const id of drawn.keys()) Plotly.relayout(id, { template: templates[name] });
  }

  for (const script of document.querySelectorAll("script[data-figure]")) {
    waiting.set(script.dataset.figure, JSON.parse(script.textContent));
  }
  show(dark.matches ? "dark" : "light");
  drawNext();
  button.addEventListener("click", () => show(theme === "dark" ? "light" : "dark"));
  dark.addEventListener("change", () => show(dark.matches ? "dark" : "light"));
  function fit() {
    contents.open = !narrow.matches;
    for (const id of drawn.keys()) redraw(id, false);
  }

  fit();
  narrow.addEventListener("change", fit);
  for (const link of contents.querySelectorAll("a")) {
    link.addEventListener("click", () => { contents.open = !narrow.matches; });
  }
  for (const fold of document.querySelectorAll("main details")) {
    fold.addEventListener("toggle", () => {
      drawNext();
      for (const plot of fold.querySelectorAll(".js-plotly-plot")) if (fold.open) Plotly.Plots.resize(plot);
    });
  }

  // What is folded is not printed.
  let before = null;
  window.addEventListener("beforeprint", () => {
    before = theme;
    show("light");
    for (const id of [...waiting.keys()]) if (document.getElementById(id).offsetParent !== null) draw(id, true);
    for (const id of drawn.keys()) redraw(id, true);
  });
  window.addEventListener("afterprint", () => {
    if (before === null) return;
    show(before);
    for (const id of drawn.keys()) redraw(id, false);
    before = null;
  });
})();
