"use strict";
// How figures with several plots are drawn on narrow pages; of the report and of the workbench.
const figuresOnNarrowPages = (function () {
  const CELL = 230; // Height of one of several plots that are stacked [px].
  const GAP = 84; // Height between them, for the labels of one and the title of the next [px].
  const narrow = window.matchMedia("(max-width: 700px)");

  function copy(value) {
    return JSON.parse(JSON.stringify(value));
  }

  // The plots of a figure in the order of reading: their axes and titles.
  function cells(layout) {
    const found = [];
    for (const key of Object.keys(layout)) {
      if (!/^xaxis\d*$/.test(key) || !layout[key].domain) continue;
      const x = layout[key];
      const y = layout["yaxis" + (x.anchor || "y").slice(1)];
      if (!y || !y.domain) continue;
      const titles = (layout.annotations || []).filter((title) => title.xref === "paper" && title.yref === "paper" &&
        title.x >= x.domain[0] && title.x <= x.domain[1] && Math.abs(title.y - y.domain[1]) < 1e-6);
      found.push({ x, y, titles, left: x.domain[0], top: y.domain[1], ids: [key.replace("axis", ""), x.anchor || "y"] });
    }
    return found.sort((a, b) => b.top - a.top || a.left - b.left);
  }

  // Puts plots that stand side by side below each other, each as wide as the page.
  function stacked(original) {
    const layout = copy(original);
    const all = cells(layout);
    if (new Set(all.map((cell) => cell.left)).size < 2) return layout;
    const margin = layout.margin;
    const height = all.length * CELL + (all.length - 1) * GAP;
    layout.height = height + margin.t + margin.b;
    all.forEach((cell, index) => {
      const top = 1 - (index * (CELL + GAP)) / height;
      const first = all.find((other) => other.top === cell.top);
      const below = all.filter((other) => other.left === cell.left && (other.x.title || {}).text).pop();
      if (!(cell.y.title || {}).text) cell.y.title = copy(first.y.title || {});
      if (!(cell.x.title || {}).text && below) cell.x.title = copy(below.x.title);
      cell.x.domain = [0, 1];
      cell.y.domain = [Math.max(0, top - CELL / height), top];
      for (const axis of [cell.x, cell.y]) axis.showticklabels = true;
      for (const title of cell.titles) Object.assign(title, { x: 0.5, y: top });
    });
    return layout;
  }

  // One of the plots of a figure that has some side by side, as wide as the page; and the names of all of them.
  // chosen: which one; the figure knows which comes first.
  function single(figure, chosen) {
    const layout = stacked(figure.layout);
    const all = cells(layout);
    if (new Set(cells(figure.layout).map((cell) => cell.left)).size < 2) return { names: [], figure };
    const index = [chosen, (layout.meta || {}).first].find((number) => all[number]) || 0;
    const shown = all[index];
    const [xref, yref] = shown.ids;
    const isHere = (x, y) => (x || "x").split(" ")[0] === xref && (y || "y").split(" ")[0] === yref;
    const moved = (item) => ({ ...item, xref: item.xref.replace(xref, "x"), yref: item.yref.replace(yref, "y") });
    const of = (kind) => (layout[kind] || []).filter((item) => isHere(item.xref, item.yref)).map(moved);
    const isEntry = (trace) => Array.isArray(trace.x) && trace.x.length === 1 && trace.x[0] === null; // of the legend
    const listed = new Set(); // of the legend, in which the figure has each name once
    const data = figure.data.filter((trace) => isEntry(trace) || isHere(trace.xaxis, trace.yaxis)).map((trace) => {
      const group = (other) => other.legendgroup || other.name;
      const isListed = (other) => other.showlegend !== false && (other === trace || group(other) === group(trace));
      const first = !group(trace) || !listed.has(group(trace));
      listed.add(group(trace));
      return { ...trace, xaxis: "x", yaxis: "y", showlegend: first && figure.data.some(isListed) };
    });
    for (const key of Object.keys(layout)) if (/^[xy]axis\d*$/.test(key)) delete layout[key];
    const [xaxis, yaxis] = [shown.x, shown.y].map((axis) => ({ ...axis, domain: [0, 1], matches: undefined }));
    [xaxis.anchor, yaxis.anchor] = ["y", "x"];
    const height = CELL + layout.margin.t + layout.margin.b;
    const own = { shapes: of("shapes"), annotations: of("annotations"), uirevision: xref };
    return { names: names(all), index, figure: { ...figure, data, layout: { ...layout, xaxis, yaxis, height, ...own } } };
  }

  // What tells the plots of a figure apart, in the titles of their axes and of their own.
  function names(all) {
    const plain = (text) => (text || "").replace(/<br>/g, " ").replace(/<[^>]*>|■/g, "").trim();
    const parts = all.map(({ x, y, titles }) => [(y.title || {}).text, (x.title || {}).text, (titles[0] || {}).text]
      .map((text, which) => plain(which ? text : (text || "").split("<br>")[0])));
    const tells = (which) => new Set(parts.map((part) => part[which])).size > 1;
    return parts.map((part) => part.filter((text, which) => text && tells(which)).join(" · "));
  }

  // The legend may take several lines on a narrow page: the plots begin below it.
  function belowLegend(Plotly, plot) {
    const legend = plot.querySelector(".legend");
    if (!legend) return;
    const extra = Math.round(legend.getBBox().height) - 28;
    if (extra <= 0) return;
    const { margin, height } = plot.layout;
    const layout = { "margin.t": margin.t + extra, height: height + extra };
    plot.style.height = layout.height + "px";
    Plotly.relayout(plot, layout);
    delete plot.layout.width; // Plotly has fixed it, together with the height.
  }

  return { copy, narrow, stacked, single, belowLegend };
})();
