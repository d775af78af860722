"""Live view of a recording in progress."""

from nicegui import ui

from ident.output.figures import time_plots
from ident.workbench.figure import Figure, to_dict
from ident.workbench.pages.page import Page, quiet, set_test_id
from ident.workbench.programs.recording_process import RunStatus

_MAX_CYCLES = 600
"""Cycles in a live plot, at most."""


def draw(page: Page) -> None:
    """Draw the live view; updates of a run change it in place, so that the layout stays still."""
    state = set_test_id(ui.label().classes("font-medium q-mt-sm"), "run-state")
    bar = ui.linear_progress(0.0, show_value=False).props("aria-hidden=true")
    counts = quiet("")
    grid = ui.element("div").classes("w-full grid grid-cols-1 md:grid-cols-2 gap-2")
    plots_by_kind: dict[str, ui.plotly] = {}
    messages = set_test_id(ui.column().classes("gap-0 font-mono text-sm whitespace-pre-wrap"), "run-messages")

    def update(page: Page) -> None:
        run = page.session.recorder.run
        state.text = (page.session.interrupted or "No run yet.") if run is None else run_summary(run)
        bar.visible = run is not None and "total" in run.status
        if run is None:
            return
        if not has_plots(run):
            grid.clear()
            plots_by_kind.clear()
        elif plots_by_kind:
            for kind, figure in live_figures(run).items():
                page.update_figure(plots_by_kind[kind], figure)
        else:
            with grid:
                for kind, figure in live_figures(run).items():
                    plots_by_kind[kind] = page.draw_figure(figure, f"{kind} while moving")
        bar.value = _share_done(run)
        counts.text = _counts(run)
        messages.clear()
        with messages:
            for line in list(run.messages)[-6:]:
                ui.label(line)

    page.watch(update, "run")


def has_plots(run: RunStatus) -> bool:
    """Whether there is something to plot. Drawing delays the keep-alives of a jog: its motion is drawn at its end."""
    return bool(run.rows) and (run.file is not None or run.exit_code is not None)


def run_summary(run: RunStatus) -> str:
    """Return a sentence about the progress or the end of the run."""
    if run.exit_code is None:
        word = {0: run.status.get("status", "starting"), 1: "stopping"}.get(run.stop_count, "quick stop")
        share = f", {_share_done(run):.1%}" if word == "stream" else ""
        return f"{run.name}: {word}{share}"
    if run.exit_code == 0:
        return f"{run.name}: {_outcome(run)}"
    if run.exit_code < 0:
        consequence = (
            "CHECK THE DRIVES: only their watchdogs are active now."
            if run.has_rig_file
            else "Its simulated drives ended with it."
        )
        return f"{run.name}: daq was killed (signal {-run.exit_code}). {consequence}"
    reason = run.reason
    if run.exit_code == 2:
        return f"{run.name}: did not start. {reason}"
    drives = "drives" if run.has_rig_file else "simulated drives"
    closed = " and the file closed" if run.file else ""
    disabled = "" if "NOT CONFIRMED" in reason else f" The {drives} were disabled{closed}."
    return f"{run.name}: ended early, {reason}.{disabled}"


def _outcome(run: RunStatus) -> str:
    if run.file:
        return "done. Choose it with Train or Validate on the left."
    if "released" not in run.status:
        return "done."
    status, unit = run.status, run.position_unit
    ended = "released" if status["released"] else "done"
    return f"{ended} after {status['to'] - status['from']:+.4f} of {status['by']:+g} {unit}; drives off."


def _share_done(run: RunStatus) -> float:
    return float(run.status.get("done", 0) / max(run.status.get("total", 1), 1))


def _counts(run: RunStatus) -> str:
    status = run.status
    if "cycles" not in status:
        return ""
    return (
        f"{status['cycles']} cycles, {status.get('answers_lost', 0)} answers lost, "
        f"{status.get('cycles_missed', 0)} cycles missed, "
        f"following error at worst {1e3 * status.get('following_error_max', 0.0):.2f} m{run.position_unit}"
    )


def live_figures(run: RunStatus) -> dict[str, Figure]:
    """Return the live plots by quantity."""
    rows, lateness, unit = list(run.rows), list(run.lateness), run.position_unit
    rows = rows[:: len(rows) // _MAX_CYCLES + 1]
    time = [row["time"] for row in rows]
    figures = {}
    for kind, label, scale in (("position", unit, 1.0), ("following error", f"m{unit}", 1e3), ("voltage", "V", 1.0)):
        joints = zip(*(row[kind.replace(" ", "_")] for row in rows), strict=True)
        curves = [[value if value is None else scale * value for value in joint] for joint in joints]
        figures[kind] = to_dict(time_plots.live(time, curves, kind, label))
    late = [1e3 * seconds for _, seconds in lateness]
    return {**figures, "lateness": to_dict(time_plots.live([time for time, _ in lateness], [late], "lateness", "ms"))}
