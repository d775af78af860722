"""`ident compare`: a model against recordings, and where it fails."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.basics.model_name import model_stem
from ident.command_options import (
    ACCEPT,
    EFFECT_FILES,
    FILE,
    JSON,
    DataCommand,
    again,
    check_choices,
    say_written,
    show_result,
)
from recordings.command_line import check_readable, output_name, refuse_existing, repeated, say_next
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from ident.identification.model_file import ModelFile


@click.command(cls=DataCommand, epilog="Example: ident compare fig5a.model.json fig5b.mcap")
@click.argument("model_path", metavar="MODEL", type=FILE)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@EFFECT_FILES
@ACCEPT
@click.option(
    "--report",
    type=FILE,
    metavar="HTML",
    help="Page with figures.  [default: names of first FILE and MODEL, .compare.html; none with --json]",
)
@click.option("--force", is_flag=True, help="Replace an existing page.")
@JSON
def command(
    model_path: Path,
    files: tuple[Path, ...],
    effect_files: tuple[Path, ...],
    accept: tuple[str, ...],
    report: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Show where the model in the file MODEL fails to explain the torque in the recordings FILE.

    Shows the residual by joint, phase of the motion, time window, quantity and frequency, and its share above the
    noise.
    """
    from functools import partial

    import ident
    from ident.output.console.residuals import show

    check_readable(model_path, *files)
    model = ident.load_model(model_path, effect_files=effect_files)
    check_choices((), (), accept)
    default = files[0].with_suffix(f".{model_stem(model_path.name)}.compare.html")
    report = report if as_json else output_name(report, default, force)
    refuse_existing(report, force=force, read=(model_path, *files, *effect_files))
    result = ident.compare(model, files, accept=accept)
    if report:
        from ident.output.report import contents, page

        request = contents.ReportRequest((model_path,), files, (), effect_files, diagnose=False)
        page.write(contents.assemble(request, {model_path.name: model.file}, {model_path.name: result}), report)
    show_result(as_json, result.as_json, partial(show, result))
    say_written(report=report)
    options = again("--effect-file", "--accept")
    train, held_out = _as_fitted(model.file, model_path, files)
    recorded = [*train, *repeated("--validate", held_out)]
    if result.within_noise:
        # The report looks for what is missing, and says if nothing is.
        say_next("ident", "report", model_path, *recorded, *options)
    else:
        start = [] if model.file.form else ["--model", model_path]
        say_next(*diagnosis(train, *recorded[len(train) :], *start, *options, model=model_path))


def _as_fitted(model: ModelFile, model_path: Path, files: Sequence[Path]) -> tuple[Sequence[Path], list[Path]]:
    """The recordings that `model` was fitted to, if they are at hand, and those of `files` that it was not."""
    from ident.identification.model_file import find_recording
    from recordings.files import sha256

    train = [find_recording(source, model_path) for source in model.train.recordings]
    at_hand = [file for file in train if file]
    if len(at_hand) < len(train):
        return files, []
    digests = {source.sha256 for source in model.train.recordings}
    return at_hand, [file for file in files if sha256(file) not in digests]
