"""Form and live view of a recording: choose motion and rig, check, start, watch, stop."""

import json
from pathlib import Path
from subprocess import CompletedProcess, TimeoutExpired

from nicegui import run as background
from nicegui import ui

from ident.workbench import plots
from ident.workbench.folder import SUFFIX
from ident.workbench.pages.page import Page, draw_figure, set_test_id
from ident.workbench.recording_process import RunStatus, run_daq
from recordings.errors import BadInput
from trajectories.library import names

SIMULATED, NO_SIM_FILE = "simulated", "default machine"
UNITS = {"position": "rad", "following error": "mrad", "voltage": "V", "lateness": "ms"}
_SAFETY = {
    True: "Simulated drives: no real robot moves.",
    False: "Real drives move, unless the rig file names simulated ones. Keep a hand on the hard-wired emergency "
    "stop; the STOP button above does not replace it.",
}
"""Safety note without (True) and with (False) a rig file."""


def draw(page: Page) -> None:
    """Draw the form, the buttons and the live view."""
    session = page.session
    files = session.folder.trajectories()
    with ui.row().classes("items-end gap-3"):
        motion = ui.select([*names(), *files], value="fig5a", label="motion")
        motion.props("dense outlined").classes("min-w-28")
        rig = ui.select([SIMULATED, *files], value=SIMULATED, label="rig").props("dense outlined").classes("min-w-36")
        sim = ui.select([NO_SIM_FILE, *files], value=NO_SIM_FILE, label="simulated machine")
        sim.props("dense outlined").classes("min-w-36")
        paces = {"": "from the rig file", "lockstep": "lockstep", "realtime": "real time"}
        pace = ui.select(paces, value="", label="pace").props("dense outlined").classes("min-w-28")
        cycles = ui.number("cycles", min=1, step=1, placeholder="20 s").props("dense outlined").classes("w-20")
        out = ui.input("file", value=_free_name(page, "fig5a")).props("dense outlined")
        motion.on_value_change(lambda: out.set_value(_free_name(page, Path(str(motion.value)).stem)))
        for element, test_id in (
            (motion, "motion"),
            (rig, "rig"),
            (pace, "pace"),
            (cycles, "cycles"),
            (out, "out"),
            (sim, "sim"),
        ):
            set_test_id(element, f"record-{test_id}")

    def arguments() -> list[str]:
        options = {
            "--traj": motion.value,
            "--rig": rig.value if rig.value != SIMULATED else None,
            "--sim": sim.value if sim.value != NO_SIM_FILE else None,
            "--pace": pace.value,
            "--cycles": int(cycles.value) if cycles.value else None,
        }
        return [str(word) for option, value in options.items() if value for word in (option, value)]

    def start() -> None:
        session.recorder.start(arguments(), session.folder.new_file(str(out.value), SUFFIX))

    checked = ui.column().classes("gap-0")
    with ui.row().classes("items-center gap-3"):
        check = ui.button("Pre-flight check", icon="checklist", on_click=lambda: _check(page, arguments(), checked))
        check.props("outline no-caps")
        set_test_id(check, "preflight")
        begin = ui.button("Record", icon="fiber_manual_record", on_click=page.handler(start)).props("no-caps")
        set_test_id(begin, "record")
        safety = ui.label(_SAFETY[True]).classes("quiet")
        set_test_id(safety, "safety")
        rig.on_value_change(lambda: safety.set_text(_SAFETY[rig.value == SIMULATED]))
    _draw_live(page)


def _free_name(page: Page, stem: str) -> str:
    used_names = set(page.session.folder.recordings())
    candidates = [f"{stem}{SUFFIX}", *(f"{stem}-{number}{SUFFIX}" for number in range(2, 1000))]
    return next(file_name for file_name in candidates if file_name not in used_names)


async def _check(page: Page, arguments: list[str], column: ui.column) -> None:
    """Run `daq check` and a dry run without power, and show the results."""
    rig = arguments[arguments.index("--rig") : arguments.index("--rig") + 2] if "--rig" in arguments else []
    column.clear()
    with column:
        ui.label("checking …").classes("quiet")
    root = page.session.folder.root
    rehearsal = ("record", *arguments, "--dry-run", "--json", "--out", "preflight.mcap")
    try:
        checked = await background.io_bound(run_daq, root, "check", "--json", *rig)
        rehearsed = await background.io_bound(run_daq, root, *rehearsal)
    except (BadInput, OSError, TimeoutExpired) as error:
        ui.notify(str(error), type="warning")
        return
    if checked is None or rehearsed is None:  # the page is being closed
        return
    column.clear()
    with column:
        for line in _check_lines(checked, "drives and bus"):
            set_test_id(ui.label(line), "preflight-check")
        for line in _check_lines(rehearsed, "dry run without power"):
            set_test_id(ui.label(line), "preflight-dry-run")


def _check_lines(process: "CompletedProcess[str]", title: str) -> list[str]:
    document = json.loads(process.stdout or "{}")
    problems = [
        f"{finding['where']}: {finding['what']}"
        for finding in document.get("findings", [])
        if finding["verdict"] == "problem"
    ]
    if process.returncode:
        return [f"✗ {title}", *problems, *(line for line in process.stderr.splitlines() if line.startswith("error"))]
    return [f"✓ {title}{': ' + document['bus'] if 'bus' in document else ''}"]


def _draw_live(page: Page) -> None:
    """Draw the live view; updates change it in place, so that the layout stays still."""
    session = page.session
    state = ui.label().classes("font-medium q-mt-sm")
    set_test_id(state, "run-state")
    bar = ui.linear_progress(0.0, show_value=False).props("aria-hidden=true")
    counts = ui.label().classes("quiet")
    with ui.element("div").classes("w-full grid grid-cols-2 gap-2"):
        figures = {kind: draw_figure(_plot(None, kind), f"{kind} while recording", session.dark) for kind in UNITS}
    messages = ui.column().classes("gap-0 font-mono text-sm")

    def update() -> None:
        run = session.recorder.run
        state.text, bar.visible = run_summary(run), run is not None
        for kind, plot in figures.items():
            plot.update_figure(plots.with_theme(_plot(run, kind), session.dark))
        if run is None:
            return
        bar.value = run.status.get("done", 0) / max(run.status.get("total", 1), 1)
        counts.text = _counts(run)
        messages.clear()
        with messages:
            for line in list(run.messages)[-6:]:
                ui.label(line)

    update()
    page.call_on_change(update, "run", min_interval=0.5)


def run_summary(run: RunStatus | None) -> str:
    """Return a sentence about the progress or the end of the run."""
    if run is None:
        return "No run yet."
    if run.exit_code is None:
        word = {0: run.status.get("status", "starting"), 1: "stopping"}.get(run.stop_count, "quick stop")
        return f"{run.file.name}: {word}"
    if run.exit_code == 0:
        return f"{run.file.name}: done. Choose it with Train or Check on the left."
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
        f"following error at worst {1e3 * status.get('following_error_max', 0.0):.2f} mrad"
    )


def _plot(run: RunStatus | None, kind: str) -> plots.Figure:
    rows, lateness = ([], []) if run is None else (list(run.rows), list(run.lateness))
    return plots.live(rows, lateness, kind, UNITS[kind])
