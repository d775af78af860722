"""The model at work: torque by its causes, torque of another motion, and export for controllers and simulators."""

from pathlib import Path

from nicegui import ui

from ident.basics.model_name import model_stem
from ident.identification.model_file import ModelFile
from ident.workbench.pages.command import Command, draw_command
from ident.workbench.pages.forms import name_fields
from ident.workbench.pages.page import (
    Page,
    draw_result,
    heading,
    say_what_comes,
    set_test_id,
)
from ident.workbench.state.cli_equivalent import torque_command
from trajectories.library import names

_TARGETS = {
    "c": ("C99 for a controller (folder)", "_c"),
    "csv": ("table of torques (CSV)", ".feedforward.csv"),
    "fmu": ("FMU for co-simulation", ".fmu"),
    "mjcf": ("MJCF for MuJoCo", ".xml"),
    "urdf": ("URDF with identified values", ".urdf"),
}
"""Label, and end of the name, of each export."""
_OF_THE_FIT = "of the fit"


def draw(page: Page) -> None:
    """Draw the uses of the current model."""
    view = page.session.selection.analysis.residuals
    if view is None:
        say_what_comes(page, "It can be put to use")
        return
    heading("Where the torque goes")
    for number, sentence in enumerate(view.causes_sentences):
        set_test_id(ui.label(sentence), f"causes-{number}")
    page.draw_figure(view.causes_figure, "torque by cause over time, and the RMS of each cause")
    draw_result(view.causes)
    _draw_torque(page, view.model)
    _draw_export(page, view.model)


def _draw_torque(page: Page, model: ModelFile) -> None:
    folder, saved = page.session.folder, page.session.saved
    heading("Torque of another motion", "q-mt-md")
    recordings = folder.recordings()
    with ui.row().classes("items-end gap-3") as row:
        path = ui.select([*recordings, *_trajectories(model)], value=recordings[0], label="motion")
        name_fields("torque", path=path.classes("min-w-56"))

    def torque() -> tuple[Command, tuple[str, ...]]:
        name, motion = saved.ensure_saved(model), str(path.value)
        stem = f"{model_stem(name)}.{Path(motion).stem}.torque"
        written = folder.free_name(stem, ".csv"), folder.free_name(stem, ".png")
        return torque_command(name, motion, motion in recordings, *written), written

    draw_command(page, row, "Compute", "torque", torque)


def _trajectories(model: ModelFile) -> tuple[str, ...]:
    return names() if model.mechanism == "delta" else ()


def _draw_export(page: Page, model: ModelFile) -> None:
    folder, saved = page.session.folder, page.session.saved

    def free_name() -> str:
        return folder.free_name(model_stem(saved.proposed_name(model)), _TARGETS[str(target.value)][1])

    heading("For a controller or a simulator", "q-mt-md")
    with ui.row().classes("items-end gap-3") as row:
        labels = {name: label for name, (label, _) in _TARGETS.items()}
        target = ui.select(labels, value="c", label="export").classes("min-w-56")
        motions = [_OF_THE_FIT, *_trajectories(model)]
        motion = ui.select(motions, value=_OF_THE_FIT, label="motion").classes("min-w-32")
        motion.tooltip("Motion of a table, of test vectors, and of the torque that is lost")
        out = ui.input("folder or file", value=free_name()).classes("min-w-56")
        target.on_value_change(lambda: out.set_value(free_name()))
        name_fields("use", target=target, motion=motion, out=out)

    def export() -> tuple[Command, tuple[str, ...]]:
        path = folder.new_file(str(out.value), _TARGETS[str(target.value)][1])
        along = () if motion.value == _OF_THE_FIT else ("--traj", str(motion.value))
        return ("ident", "export", saved.ensure_saved(model), "--to", str(target.value), "-o", path.name, *along), (
            path.name,
        )

    draw_command(page, row, "Export", "use-export", export)
