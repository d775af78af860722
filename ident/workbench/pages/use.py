"""The model at work: torque by its causes, export for controllers, and the robot that follows better with it."""

from collections.abc import Awaitable
from pathlib import Path

from nicegui import ui

from ident.basics.model_name import model_stem
from ident.identification.model_file import ModelFile
from ident.output.tables import per_joint
from ident.workbench.pages.command import Command, draw_command, draw_written
from ident.workbench.pages.forms import machine_fields, name_fields
from ident.workbench.pages.page import (
    Page,
    draw_code,
    draw_result,
    draw_table,
    heading,
    in_background,
    quiet,
    say_what_comes,
    set_test_id,
)
from ident.workbench.programs.feedforward_comparison import MOTION, WITH, WITHOUT, ComparisonResult
from ident.workbench.state.cli_equivalent import torque_command
from ident.workbench.state.model_export import ControllerFiles, targets_of
from trajectories.library import names

_LABELS = {
    "c": "C99 for a controller (folder)",
    "csv": "table of torques (CSV)",
    "fmu": "FMU for co-simulation",
    "mjcf": "MJCF for MuJoCo",
    "urdf": "URDF with identified values",
}
_OF_THE_FIT = "of the fit"


def draw(page: Page) -> None:
    """Draw the three uses of the current model."""
    page.draw_on_change(_draw_causes, "residuals")
    page.draw_on_change(_draw_torque, "residuals")
    page.draw_on_change(_draw_uses, "residuals", "saved", "use")


def _draw_causes(page: Page) -> None:
    view = page.session.selection.analysis.residuals
    if view is None:
        say_what_comes(page, "It can be put to use")
        return
    heading("Where the torque goes")
    for number, sentence in enumerate(view.causes_sentences):
        set_test_id(ui.label(sentence), f"causes-{number}")
    page.draw_figure(view.causes_figure, "torque by cause over time, and the RMS of each cause")
    draw_result(view.causes)


def _draw_torque(page: Page) -> None:
    view, folder, export = page.session.selection.analysis.residuals, page.session.folder, page.session.export
    if view is None:
        return
    model = view.model
    heading("Torque of another motion", "q-mt-md")
    recordings = folder.recordings()
    with ui.row().classes("items-end gap-3") as row:
        path = ui.select([*recordings, *_trajectories(model)], value=recordings[0], label="motion")
        name_fields("torque", path=path.classes("min-w-56"))

    def torque() -> tuple[Command, tuple[str, ...]]:
        name, motion = export.ensure_saved(model), str(path.value)
        stem = f"{model_stem(name)}.{Path(motion).stem}.torque"
        written = folder.free_name(stem, ".csv"), folder.free_name(stem, ".png")
        return torque_command(name, motion, motion in recordings, *written), written

    draw_command(page, row, "Compute", "torque", torque)


def _trajectories(model: ModelFile) -> tuple[str, ...]:
    return names() if model.mechanism == "delta" else ()


def _draw_uses(page: Page) -> None:
    view = page.session.selection.analysis.residuals
    if view is not None:
        _draw_export(page, view.model)
        _draw_comparison(page, view.model)


def _draw_export(page: Page, model: ModelFile) -> None:
    export = page.session.export
    model_name = export.proposed_name(model)
    heading("For a controller or a simulator", "q-mt-md")
    with ui.row().classes("items-end gap-3"):
        options = {target: _LABELS[target] for target in targets_of(model.mechanism)}
        target = ui.select(options, value="c", label="export").classes("min-w-56")
        motions = [_OF_THE_FIT, *_trajectories(model)]
        motion = ui.select(motions, value=_OF_THE_FIT, label="motion").classes("min-w-32")
        motion.tooltip("Motion of a table, of test vectors, and of the torque that is lost")
        out = ui.input("folder or file", value=export.free_name(model_name, "c")).classes("min-w-56")
        target.on_value_change(lambda: out.set_value(export.free_name(model_name, str(target.value))))
        name_fields("use", target=target, motion=motion, out=out)

        def write() -> Awaitable[None]:
            chosen = None if motion.value == _OF_THE_FIT else str(motion.value)
            return in_background(export.export, model, str(target.value), str(out.value), chosen)

        page.button("Export", "use-export", write, icon="output").enabled = not export.exporting
    if export.exporting:
        quiet("Exporting …")
    if files := export.export_of(model):
        _draw_losses(page, files)


def _draw_losses(page: Page, files: ControllerFiles) -> None:
    """Draw what the exported model lacks."""
    document = files.document
    whole, lost = document["torque_rms"], document["not_carried"]

    def shares(rms: list[float]) -> list[str]:
        pairs = zip(rms, whole, strict=True)
        return [f"{x:.3g} ({x / torque:.1%})" if torque else f"{x:.3g}" for x, torque in pairs]

    ui.label(f"Written next to the recordings: {files.out}, from {files.model_name}.")
    draw_written(page, (files.out,))
    carried = ", ".join(document["carried"]) or "no effect beside the mechanism"
    set_test_id(ui.label(f"Carried: {carried}.{' Not carried:' if lost else ''}"), "use-carried")
    if document["voltage_only"]:
        quiet(f"Without any torque of their own: {', '.join(document['voltage_only'])}.")
    if lost:
        rows = [(entry["effect"], *shares(entry["torque_lost_rms"]), entry["why"]) for entry in lost]
        rows.append(("all of them", *shares(document["torque_lost_rms"]), ""))
        head = per_joint("torque lost on " + document["motion"], len(whole), "why")
        draw_table(head, rows, words=(0, len(head) - 1))
    draw_code(" ".join(files.command) + "\n", "use-export-command")


def _draw_comparison(page: Page, model: ModelFile) -> None:
    comparison, session = page.session.comparison, page.session
    heading("Does the robot follow better with it?", "q-mt-md")
    if model.mechanism != "delta":
        quiet(f"Only the simulated delta robot can be tried here; it runs {MOTION}.")
        return
    quiet(
        f"Records {MOTION} twice on the simulated rig: without, and with the model's torque fed forward. The machine "
        "should be the one of the training recording."
    )
    with ui.row().classes("items-end gap-3"):
        machine = machine_fields("use", session.folder.names(".toml"))

        def start() -> None:
            comparison.start(model, session.export.ensure_saved(model), machine())

        button = page.button("Record both", "use-compare", start, icon="compare_arrows")
        button.enabled = comparison.state is None
    if comparison.state or comparison.problem:
        set_test_id(ui.label(comparison.state or f"✗ {comparison.problem}"), "use-state").props("role=status")
    result = comparison.of(model)
    if result:
        _draw_result(page, result)


def _draw_result(page: Page, result: ComparisonResult) -> None:
    without, fed = result.runs
    sentence = (
        f"The following error (RMS of all joints) is {fed.overall / without.overall:.0%} of that without "
        f"feed-forward: {1e3 * without.overall:.3g} to {1e3 * fed.overall:.3g} mrad."
    )
    set_test_id(ui.label(sentence), "use-result")
    rows = []
    for kind, run, name in zip((WITHOUT, WITH), result.runs, result.files, strict=True):
        pairs = list(zip(run.rms, run.worst, strict=True))
        if run.platform_rms is not None and run.platform_worst is not None:
            pairs.append((run.platform_rms, run.platform_worst))
        rows.append((kind, *(f"{1e3 * rms:.3f} ({1e3 * worst:.3f})" for rms, worst in pairs), name))
    joints = [f"joint {number} [mrad]" for number in range(1, len(without.rms) + 1)]
    head = ("RMS (worst)", *joints, "platform [mm]", "recording")
    draw_table(head, rows, words=(0, len(head) - 1))
    page.draw_figure(result.figure, "following error over time, without and with the model")
