"""The model at work: torque by its causes, export for controllers, and the robot that follows better with it."""

from nicegui import run as background
from nicegui import ui

from ident.data.following_error import Following
from ident.identification.model_file import ModelFile
from ident.workbench.controller_export import ControllerFiles, targets_of
from ident.workbench.feedforward_comparison import MOTION, WITH, WITHOUT, ComparisonResult
from ident.workbench.pages.page import Page, draw_code, draw_table, heading, notify, set_test_id
from ident.workbench.views import CausesView, StepsView
from recordings.errors import BadInput
from trajectories.library import names

_LABELS = {
    "c": "C99 for a controller (folder)",
    "csv": "table of torques (CSV)",
    "fmu": "FMU for co-simulation",
    "mjcf": "MJCF for MuJoCo",
}
_NO_MODEL = "Fit a model first, and put it to use here."
_WHEN_ANALYSED = "The model can be put to use here when it has been analysed."
_OF_THE_FIT = "of the fit"
_DEFAULT_MACHINE = "default machine"


def draw(page: Page) -> None:
    """Draw the three uses of the current model."""
    page.draw_on_change(_draw_causes, "residuals", "step_list")
    page.draw_on_change(_draw_export, "residuals", "step_list", "saved", "use")
    page.draw_on_change(_draw_comparison, "residuals", "step_list", "saved", "use")


def _current(page: Page) -> tuple[ModelFile, StepsView, CausesView] | None:
    """The current model with its list of steps and causes, once it has been analysed."""
    step_list, residuals = page.session.selection.step_list, page.session.selection.residuals
    return (residuals.model, step_list, residuals.causes) if step_list and residuals else None


def _draw_causes(page: Page) -> None:
    current = _current(page)
    if current is None:
        fitted = page.session.selection.step_list is not None
        ui.label(_WHEN_ANALYSED if fitted else _NO_MODEL).classes("quiet")
        return
    causes = current[2]
    heading("Where the torque goes")
    for number, sentence in enumerate(causes.sentences):
        set_test_id(ui.label(sentence), f"causes-{number}")
    page.draw_figure(causes.figure, "torque by cause over time, and the RMS of each cause")
    ui.label(causes.caption).classes("quiet")
    draw_table(causes.head, causes.rows, words=(0,))


def _draw_export(page: Page) -> None:
    current = _current(page)
    if current is None:
        return
    model, step_list, _ = current
    export = page.session.controller_export
    model_name = page.session.export.saved_name(model) or page.session.export.free_name(step_list)
    heading("For a controller or a simulator", "q-mt-md")
    with ui.row().classes("items-end gap-3"):
        options = {target: _LABELS[target] for target in targets_of(model.mechanism)}
        target = ui.select(options, value="c", label="export").classes("min-w-56")
        motions = [_OF_THE_FIT, *(names() if model.mechanism == "delta" else ())]
        motion = ui.select(motions, value=_OF_THE_FIT, label="motion").classes("min-w-32")
        motion.tooltip("Motion of a table, of test vectors, and of the torque that is lost")
        out = ui.input("folder or file", value=export.free_name(model_name, "c")).classes("min-w-56")
        target.on_value_change(lambda: out.set_value(export.free_name(model_name, str(target.value))))
        for test_id, element in {"target": target, "motion": motion, "out": out}.items():
            set_test_id(element, f"use-{test_id}").props("dense outlined")

        async def write() -> None:
            try:
                saved = page.session.export.ensure_saved(model, step_list)
                chosen = None if motion.value == _OF_THE_FIT else str(motion.value)
                error = await background.io_bound(
                    export.export, model, saved, str(target.value), str(out.value), chosen
                )
            except (BadInput, OSError) as problem:
                error = str(problem)
            if error:
                notify(error, "warning")

        button = set_test_id(ui.button("Export", icon="output", on_click=write), "use-export")
        button.enabled = not export.running
    if export.running:
        ui.label("Exporting …").classes("quiet")
    files = export.of(model)
    if files:
        _draw_losses(files)


def _draw_losses(files: ControllerFiles) -> None:
    """Draw what the exported model lacks."""
    document = files.document
    whole = document["torque_rms"]
    carried = ", ".join(document["carried"]) or "no effect beside the mechanism"
    lost = document["not_carried"]
    ui.label(f"Written next to the recordings: {files.out}, from {files.model_name}.")
    sentence = f"Carried: {carried}." if not lost else f"Carried: {carried}. Not carried:"
    set_test_id(ui.label(sentence), "use-carried")
    if document["voltage_only"]:
        ui.label(f"Without any torque of their own: {', '.join(document['voltage_only'])}.").classes("quiet")
    if lost:
        joints = [f"joint {number}" for number in range(1, len(whole) + 1)]
        rows = [(entry["effect"], *_shares(entry["torque_lost_rms"], whole), entry["why"]) for entry in lost]
        rows.append(("all of them", *_shares(document["torque_lost_rms"], whole), ""))
        draw_table(("torque lost on " + document["motion"], *joints, "why"), rows, words=(0, len(joints) + 1))
    draw_code(" ".join(files.command) + "\n", "use-export-command")


def _shares(rms: list[float], whole: list[float]) -> tuple[str, ...]:
    return tuple(
        f"{x:.3g} ({x / torque:.1%})" if torque else f"{x:.3g}" for x, torque in zip(rms, whole, strict=True)
    )


def _draw_comparison(page: Page) -> None:
    current = _current(page)
    if current is None:
        return
    model, step_list, _ = current
    comparison, session = page.session.comparison, page.session
    heading("Does the robot follow better with it?", "q-mt-md")
    if model.mechanism != "delta":
        ui.label(f"Only the simulated delta robot can be tried here; it runs {MOTION}.").classes("quiet")
        return
    ui.label(
        f"Records {MOTION} twice on the simulated rig: without, and with the model's torque fed forward. The machine "
        "should be the one of the training recording."
    ).classes("quiet")
    with ui.row().classes("items-end gap-3"):
        machines = [_DEFAULT_MACHINE, *session.folder.names(".toml")]
        sim = ui.select(machines, value=_DEFAULT_MACHINE, label="simulated machine").classes("min-w-36")
        hidden = ui.number("hidden seed", min=0, step=1, format="%d", placeholder="none").classes("w-28")
        for test_id, element in {"sim": sim, "hidden": hidden}.items():
            set_test_id(element, f"use-{test_id}").props("dense outlined")

        def start() -> None:
            machine = {
                "--sim": str(sim.value) if sim.value != _DEFAULT_MACHINE else None,
                "--hidden": str(int(hidden.value)) if hidden.value is not None else None,
            }
            given = {option: value for option, value in machine.items() if value is not None}
            comparison.start(model, session.export.ensure_saved(model, step_list), given)

        button = page.button("Record both", "use-compare", start, icon="compare_arrows")
        button.enabled = comparison.state is None
    if comparison.state or comparison.problem:
        set_test_id(ui.label(comparison.state or f"✗ {comparison.problem}"), "use-state").props("role=status")
    result = comparison.of(model)
    if result:
        _draw_result(page, result)


def _draw_result(page: Page, result: ComparisonResult) -> None:
    without, fed = result.runs
    set_test_id(
        ui.label(
            f"The following error (RMS of all joints) is {fed.overall / without.overall:.0%} of that without "
            f"feed-forward: {1e3 * without.overall:.3g} to {1e3 * fed.overall:.3g} mrad."
        ),
        "use-result",
    )
    joints = [f"joint {number} [mrad]" for number in range(1, len(without.rms) + 1)]
    draw_table(
        ("RMS (worst)", *joints, "platform [mm]", "recording"),
        [
            (kind, *_cells(run), name)
            for kind, run, name in zip((WITHOUT, WITH), result.runs, result.files, strict=True)
        ],
        words=(0, len(joints) + 2),
    )
    page.draw_figure(result.figure, "following error over time, without and with the model")


def _cells(run: Following) -> tuple[str, ...]:
    pairs = list(zip(run.rms, run.worst, strict=True))
    if run.platform_rms is not None and run.platform_worst is not None:
        pairs.append((run.platform_rms, run.platform_worst))
    return tuple(f"{1e3 * rms:.3f} ({1e3 * worst:.3f})" for rms, worst in pairs)
