"""Live view of a recording in progress."""

from nicegui import ui

from ident.workbench import plots
from ident.workbench.pages.page import Page, set_test_id
from ident.workbench.recording_process import RunStatus


def draw(page: Page) -> None:
    """Draw the live view; updates change it in place, so that the layout stays still."""
    state = set_test_id(ui.label().classes("font-medium q-mt-sm"), "run-state")
    bar = ui.linear_progress(0.0, show_value=False).props("aria-hidden=true")
    counts = ui.label().classes("quiet")
    with ui.element("div").classes("w-full grid grid-cols-2 gap-2"):
        figures = {
            kind: page.draw_figure(figure, f"{kind} while recording") for kind, figure in live_figures(None).items()
        }
    messages = ui.column().classes("gap-0 font-mono text-sm")

    def update(page: Page) -> None:
        run = page.session.recorder.run
        state.text, bar.visible = run_summary(run), run is not None
        for kind, figure in live_figures(run).items():
            page.update_figure(figures[kind], figure)
        if run is None:
            return
        bar.value = run.status.get("done", 0) / max(run.status.get("total", 1), 1)
        counts.text = _counts(run)
        messages.clear()
        with messages:
            for line in list(run.messages)[-6:]:
                ui.label(line)

    page.call_now_and_on_change(update, "run", min_interval=0.5)


def run_summary(run: RunStatus | None) -> str:
    """Return a sentence about the progress or the end of the run."""
    if run is None:
        return "No run yet."
    if run.exit_code is None:
        word = {0: run.status.get("status", "starting"), 1: "stopping"}.get(run.stop_count, "quick stop")
        return f"{run.file.name}: {word}"
    if run.exit_code == 0:
        return f"{run.file.name}: done. Choose it with Train or Validate on the left."
    if run.exit_code < 0:
        consequence = (
            "CHECK THE DRIVES: only their watchdogs are active now."
            if run.has_rig_file
            else "Its simulated drives ended with it."
        )
        return f"{run.file.name}: daq was killed (signal {-run.exit_code}). {consequence}"
    reason = next(
        (line for line in reversed(run.messages) if line.startswith("error")), f"exit status {run.exit_code}"
    )
    if run.exit_code == 2:
        return f"{run.file.name}: did not start. {reason}"
    drives = "drives" if run.has_rig_file else "simulated drives"
    disabled = "" if "NOT CONFIRMED" in reason else f" The {drives} were disabled and the file closed."
    return f"{run.file.name}: ended early, {reason}.{disabled}"


def _counts(run: RunStatus) -> str:
    status = run.status
    if "cycles" not in status:
        return ""
    return (
        f"{status['cycles']} cycles, {status.get('answers_lost', 0)} answers lost, "
        f"{status.get('cycles_missed', 0)} cycles missed, "
        f"following error at worst {1e3 * status.get('following_error_max', 0.0):.2f} m{run.position_unit}"
    )


def live_figures(run: RunStatus | None) -> dict[str, plots.Figure]:
    """Return the live plots by quantity."""
    rows, lateness = (list(run.rows), list(run.lateness)) if run else ([], [])
    angle = run.position_unit if run else "rad"
    units = {"position": angle, "following error": f"m{angle}", "voltage": "V", "lateness": "ms"}
    return {kind: plots.live(rows, lateness, kind, unit) for kind, unit in units.items()}
