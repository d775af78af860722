"use strict";
(function () {
  const SPAN = 20; // of time shown [s]
  const POINTS = 1500; // of a line, at most
  const REPORTS = 4; // warnings and errors shown
  const PAUSE = 200; // between two drawings [ms]
  const PLOTS = {
    position: { title: "position; dotted: commanded [rad]", rows: true },
    error: { title: "following error [mrad]", rows: true },
    voltage: { title: "voltage [V]", rows: true },
    torque: { title: "torque; dotted: the model's [N m, N]", rows: true },
    residual: { title: "residual of the model; dotted: noise floor [N m, N]", rows: true },
    lateness: { title: "lateness, worst of each 0.1 s [ms]", rows: false },
  };
  const rows = [];
  const late = [];
  const watched = [];
  const reported = [];
  let look = null;
  let changed = false;

  const at = (id) => document.getElementById(id);
  const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

  function began(said) {
    look = said;
    at("title").textContent = `${said.run.motion} on ${said.run.rig}, into ${said.run.out}`;
    at("simulated").hidden = !said.run.simulated;
    at("state").textContent = "starting";
  }

  function went(said) {
    at("state").textContent = said.status;
    at("progress").value = said.done / Math.max(said.total, 1);
    at("figures").textContent =
      `${said.cycles} cycles, ${said.answers_lost} answers lost, ${said.cycles_missed} cycles missed, ` +
      `following error at worst ${(1e3 * said.following_error_max).toFixed(2)} mrad`;
    if (said.reports.length) {
      reported.push(...said.reports.filter((text) => !text.startsWith("info")));
      at("reports").textContent = reported.slice(-REPORTS).join("\n");
    }
    if (said.rows.length === 0) return;
    rows.push(...said.rows);
    const now = said.rows[said.rows.length - 1].time;
    late.push({ time: now, lateness: said.lateness });
    for (const kept of [rows, late]) {
      const first = kept.findIndex((one) => one.time > now - SPAN);
      kept.splice(0, first);
    }
    changed = true;
  }

  function compared(said) {
    if (said.alarm) {
      const { joints, effect, kind, since, confusable_with: others } = said.alarm;
      const name = effect === null ? "unknown" : [effect, ...others].join(" or ");
      at("alarm").textContent = `ALARM: joint ${joints.join(", ")} since ${since.toFixed(1)} s (${kind}): ${name}`;
      at("alarm").hidden = false;
    }
    if (!said.samples) return;
    const { time, measured, model, residual, terms } = said.samples;
    watched.push(...time.map((t, i) => (
      { time: t, measured: measured[i], model: model[i], residual: residual[i], floor: said.floor_rms })));
    watched.splice(0, watched.findIndex((one) => one.time > time[time.length - 1] - SPAN));
    const causes = Object.entries(terms).map(([name, values]) => `${name} ${values.length ? rms(values) : ""}`);
    at("causes").textContent = `causes, RMS by joint: ${causes.join("; ")}`;
    for (const id of ["torque", "residual", "causes"]) at(id).hidden = false;
    changed = true;
  }

  function rms(values) {
    const mean = (j) => values.reduce((sum, row) => sum + (row[j] ?? 0) ** 2, 0) / values.length;
    return values[0].map((_, j) => Math.sqrt(mean(j)).toPrecision(2)).join(", ");
  }

  function ended(text) {
    source.close();
    document.querySelector("header").classList.add("ended");
    at("state").textContent = text;
  }

  function heard(event) {
    const said = JSON.parse(event.data);
    if ("run" in said) began(said);
    else if ("rows" in said) went(said);
    else if ("watch" in said) compared(said.watch);
    else if ("killed" in said) ended("daq record was killed. LOOK AT THE DRIVES: only their watchdogs act now.");
    else if (said.ended === null) ended(`done: ${look.run.out} is whole`);
    else ended(`ended early: ${said.ended}`);
  }

  function traces(id) {
    if (!PLOTS[id].rows) {
      const y = late.map((one) => 1e3 * one.lateness);
      return [{ x: late.map((one) => one.time), y, name: "lateness", line: { color: look.grey, width: 1.2 } }];
    }
    const ofModel = id === "torque" || id === "residual";
    const all = ofModel ? watched : rows;
    const stride = Math.ceil(all.length / POINTS);
    const shown = all.filter((_, i) => i % stride === 0);
    const x = shown.map((row) => row.time);
    return look.run.joints.flatMap((_, j) => {
      const color = look.colours[j % look.colours.length];
      const name = `joint ${j + 1}`;
      const line = { color, width: 1.2 };
      if (id === "voltage") return [{ x, y: shown.map((row) => row.voltage[j]), name, line }];
      if (id === "error") return [{ x, y: shown.map((row) => milli(row.following_error[j])), name, line }];
      const [solid, dotted, what] = {
        position: ["position", "command", "commanded"],
        torque: ["measured", "model", "model"],
        residual: ["residual", "floor", "noise floor"],
      }[id];
      return [
        { x, y: shown.map((row) => row[solid][j]), name, line },
        { x, y: shown.map((row) => row[dotted][j]), name: `${name}, ${what}`, showlegend: false,
          line: { color: look.grey, width: 1.2, dash: "dot" } },
      ];
    });
  }

  function milli(value) {
    return value === null ? null : 1e3 * value; // a gap stays one
  }

  function layout(id) {
    const axis = { gridcolor: css("--line"), linecolor: css("--line"), zeroline: false, automargin: true };
    const { clientWidth: width, clientHeight: height } = at(id);
    return {
      width, height,
      title: { text: PLOTS[id].title, font: { size: 14 }, x: 0.02, y: 0.98, yanchor: "top", pad: { t: 6 } },
      font: { color: css("--ink"), size: 12, family: getComputedStyle(document.body).fontFamily },
      paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)",
      margin: { l: 56, r: 14, t: 36, b: 48 },
      xaxis: { ...axis, title: { text: "time since the first SYNC [s]", font: { size: 12 }, standoff: 4 } },
      yaxis: { ...axis, rangemode: PLOTS[id].rows ? "normal" : "tozero" },
      showlegend: id !== "lateness",
      legend: { orientation: "h", x: 1, xanchor: "right", y: 1, yanchor: "bottom" },
      uirevision: "kept",
    };
  }

  function draw() {
    if (changed && look !== null && !document.hidden) {
      changed = false;
      for (const id of Object.keys(PLOTS)) {
        if (at(id).hidden) continue;
        const lines = traces(id).map((one) => ({ mode: "lines", ...one }));
        Plotly.react(at(id), lines, layout(id), { displayModeBar: false });
      }
    }
    setTimeout(draw, PAUSE);
  }

  const source = new EventSource("/events");
  source.onmessage = heard;
  source.onerror = () => ended("The view has lost the run; look at the terminal of daq record.");
  addEventListener("resize", () => { changed = true; });
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { changed = true; });
  draw();
})();
