"""`ident report`: models, residuals, diagnosis and data quality in one HTML file."""

from pathlib import Path

import click

from ident.command_options import (
    ACCEPT,
    EFFECT_FILES,
    FILE,
    DataCommand,
    again,
    c_export,
    check_choices,
    check_outputs,
    say_written,
)
from recordings.command_line import check_readable, output_name, say_next
from recordings.errors import BadInput, ForeignFile
from recordings.next_command import diagnosis


@click.command(
    cls=DataCommand,
    short_help="Write models, residuals and diagnosis into one HTML file.",
    epilog="Example: ident report fig5a.model.json fig5a.mcap --validate fig5b.mcap -o report.html",
)
@click.argument("files", metavar="MODEL... FILE...", nargs=-1, required=True, type=FILE)
@click.option(
    "-o", "--out", type=FILE, metavar="HTML", help="File to write.  [default: first FILE's name, .report.html]"
)
@click.option(
    "--validate",
    "held_out",
    multiple=True,
    type=FILE,
    metavar="FILE",
    help="A recording that the fit did not use. May be repeated.",
)
@click.option(
    "--response",
    "responses",
    multiple=True,
    type=FILE,
    metavar="FILE",
    help="A recording of `daq response`: its Bode plot tells a delay from elasticity. May be repeated.",
)
@click.option(
    "--diagnose/--no-diagnose", default=True, show_default=True, help="Find the physical effects that are missing."
)
@EFFECT_FILES
@ACCEPT
@click.option("--force", is_flag=True, help="Replace an existing report.")
def command(
    files: tuple[Path, ...],
    out: Path | None,
    held_out: tuple[Path, ...],
    responses: tuple[Path, ...],
    diagnose: bool,
    effect_files: tuple[Path, ...],
    accept: tuple[str, ...],
    force: bool,
) -> None:
    """Compare the models MODEL (.json) with the recordings FILE (.mcap) in one HTML file, which opens in any browser.

    Shows the data quality, where the models fail, which effect is missing, the unexplained residual, and how to
    reproduce it. The file loads nothing from a network and can be sent to others. Models stand side by side.
    """
    check_readable(*files)
    models, recordings = _split_by_suffix(files)
    out = output_name(out, recordings[0].with_suffix(".report.html"), force)
    inputs = (*models, *recordings, *held_out, *responses)
    places = [path.resolve() for path in inputs]
    if twice := [path for path, place in zip(inputs, places, strict=True) if places.count(place) > 1]:
        raise BadInput(f"each file once expected, {twice[0]} found twice; leave one out")
    check_readable(*held_out, *responses)
    check_choices((), effect_files, accept)
    check_outputs(out, force=force, read=inputs)

    from rich.console import Console

    from ident.output.console.diagnosis import show_conclusion
    from ident.output.report import contents, page
    from ident.output.report.headline import nothing_more_is_missing
    from recordings.progress import progress_bar

    with progress_bar("reading") as progress:
        gathered = contents.gather(
            contents.ReportRequest(
                models, recordings, held_out, effect_files, diagnose, responses=responses, accept=accept
            ),
            progress,
        )
        progress("drawing")
        page.write(gathered, out)
    nothing_more = nothing_more_is_missing(gathered)
    if gathered.diagnosis:
        show_conclusion(gathered.diagnosis.document, Console(), nothing_more)
    say_written(report=out)
    within_noise = any(analysis.within_noise for analysis in gathered.primary_analyses.values())
    missing = gathered.diagnosis.verdict == "missing-effect" if gathered.diagnosis else not within_noise
    if nothing_more or not missing:
        # What a diagnosis could add, it has added: the road ends with the use of the last model, which is the best.
        say_next(*c_export(models[-1]))
    else:
        say_next(*diagnosis(recordings, *again("--validate", "--effect-file", "--accept"), model=models[0]))


def _split_by_suffix(files: tuple[Path, ...]) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Split `files` by suffix into models and recordings."""
    models = tuple(path for path in files if path.suffix == ".json")
    recordings = tuple(path for path in files if path.suffix == ".mcap")
    for path in files:
        if path not in (*models, *recordings):
            message = f"{path}: a model (.json) or a recording (.mcap) expected, found something else"
            raise ForeignFile(message, path)
    if not models or not recordings:
        missing = "model (.json)" if not models else "recording (.mcap)"
        raise BadInput(f"at least one model (.json) and one recording (.mcap) expected, no {missing} found; add it")
    return models, recordings
