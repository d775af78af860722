"""Form of a recording: choose motion and rig, check, start."""

import json
from pathlib import Path
from subprocess import CompletedProcess

from nicegui import ui

from ident.workbench.folder import SUFFIX
from ident.workbench.pages import commission, live, truth
from ident.workbench.pages.forms import as_word, keep_fields, name_fields
from ident.workbench.pages.page import Page, in_background, quiet, set_test_id
from ident.workbench.programs.running import as_words, daq_command, errors, run
from trajectories.library import names

_SIMULATED, _DEFAULT_MACHINE, _NO_MODEL = "simulated", "default machine", "none"
_PACES = {"": "from the rig file", "lockstep": "lockstep", "realtime": "real time"}
_SAFETY = {
    True: "Simulated drives: no real robot moves.",
    False: "Real drives move, unless the rig file names simulated ones. Keep a hand on the hard-wired emergency "
    "stop; the STOP button above does not replace it.",
}
"""Safety note without (True) and with (False) a rig file."""


def draw(page: Page) -> None:
    """Draw the form, the buttons and the live view."""
    session = page.session
    files = session.folder.names(".csv", ".toml")
    with ui.row().classes("items-end gap-3"):
        motion = ui.select([*names(), *files], value="fig5a", label="motion").classes("min-w-28")
        rig = ui.select([_SIMULATED, *files], value=_SIMULATED, label="rig").classes("min-w-36")
        pace = ui.select(_PACES, value="", label="pace").classes("min-w-28")
        cycles = ui.number("cycles", step=1, placeholder="20 s").classes("w-20")
        sim = ui.select([_DEFAULT_MACHINE, *files], value=_DEFAULT_MACHINE, label="simulated machine")
        hidden = ui.input("hidden seed", placeholder="none").classes("w-28")
        hidden.tooltip("Hides effects drawn from this seed in the simulated robot; Reveal opens them")
        model = ui.select([_NO_MODEL, *session.folder.models()], value=_NO_MODEL, label="feed-forward")
        model.tooltip("Sends the torque of this model along with each target: does the robot follow better?")
        out = ui.input("file", value=session.folder.free_name("fig5a", SUFFIX))
        motion.on_value_change(lambda: out.set_value(proposed()))
        machine = {"sim": sim.classes("min-w-36"), "hidden": hidden, "model": model.classes("min-w-36")}
        keep_fields(page, "record", motion=motion, rig=rig, pace=pace, cycles=cycles, **machine)
        name_fields("record", out=out)

    def proposed() -> str:
        return session.folder.free_name(Path(str(motion.value)).stem, SUFFIX)

    def arguments() -> dict[str, str]:
        values = {
            "--traj": motion.value,
            "--rig": rig.value if rig.value != _SIMULATED else None,
            "--pace": pace.value,
            "--cycles": as_word(cycles),
            "--sim": sim.value if sim.value != _DEFAULT_MACHINE else None,
            "--hidden": hidden.value if rig.value == _SIMULATED else None,
            "--feedforward": model.value if model.value != _NO_MODEL else None,
        }
        return {option: str(value) for option, value in values.items() if value}

    checked = ui.column().classes("gap-0")
    with ui.row().classes("items-center gap-3"):
        page.button(
            "Pre-flight check",
            "preflight",
            lambda: _check(page, arguments(), checked),
            icon="checklist",
            props="outline",
        )
        page.button(
            "Record",
            "record",
            lambda: session.recorder.start(arguments(), session.folder.new_file(out.value or proposed(), SUFFIX)),
            icon="fiber_manual_record",
        )
        safety = set_test_id(quiet(_SAFETY[rig.value == _SIMULATED]), "safety")
        rig.on_value_change(lambda: safety.set_text(_SAFETY[rig.value == _SIMULATED]))

    def move_on(page: Page) -> None:
        """Propose another file when the one named has been recorded."""
        if out.value in session.folder.names(SUFFIX):
            out.value = proposed()

    page.watch(move_on, "folder", now=False)
    commission.draw(page, arguments)
    live.draw(page)
    page.draw_on_change(truth.draw, "folder")


async def _check(page: Page, options: dict[str, str], column: ui.column) -> None:
    """Run `daq check` and a dry run without power, and show the results."""
    column.clear()
    rig = {option: value for option, value in options.items() if option == "--rig"}
    shown = {option: value for option, value in options.items() if option != "--hidden"}  # nothing is recorded
    dry_run = ("record", *as_words(shown), "--dry-run", "--json", "--out", "preflight.mcap")
    for test_id, title, command in (
        ("preflight-check", "drives and bus", ("check", "--json", *as_words(rig))),
        ("preflight-dry-run", "dry run without power", dry_run),
    ):
        process = await in_background(run, page.session.folder.root, daq_command(), command)
        if process is None:
            return
        with column:
            for line in _check_lines(process, title):
                set_test_id(ui.label(line), test_id)


def _check_lines(process: "CompletedProcess[str]", title: str) -> list[str]:
    document = json.loads(process.stdout or "{}")
    if process.returncode:
        problems = [found for found in document.get("findings", []) if found["verdict"] == "problem"]
        lines = [f"{found['where']}: {found['what']}" for found in problems]
        return [f"✗ {title}", *lines, *errors(process.stderr.splitlines())]
    return [f"✓ {title}{': ' + document['bus'] if 'bus' in document else ''}"]
