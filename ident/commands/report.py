"""`ident report`: all that is known of a model, in one HTML file."""

from pathlib import Path

import click

from recordings.command_line import refuse_existing
from recordings.errors import BadInput

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Put all that is known into one HTML file.",
    epilog="Example: ident report fig5a.model.json fig5a.mcap --validate fig5b.mcap -o report.html",
)
@click.argument("files", metavar="MODEL... FILE...", nargs=-1, required=True, type=FILE)
@click.option("-o", "--out", type=FILE, metavar="HTML", help="Where to.  [default: first FILE's name, .report.html]")
@click.option(
    "--validate",
    "held_out",
    multiple=True,
    type=FILE,
    metavar="FILE",
    help="A recording that the fit did not see; may be given several times.",
)
@click.option(
    "--diagnose/--no-diagnose", default=True, show_default=True, help="Find out which physical effect is missing."
)
@click.option(
    "--effect-file",
    "effect_files",
    multiple=True,
    type=FILE,
    metavar="PY",
    help="An effect of your own; it is executed.",
)
@click.option("--force", is_flag=True, help="Replace an existing report.")
def command(
    files: tuple[Path, ...],
    out: Path | None,
    held_out: tuple[Path, ...],
    diagnose: bool,
    effect_files: tuple[Path, ...],
    force: bool,
) -> None:
    """Show the models MODEL (.json) against the recordings FILE (.mcap) in one HTML file, which opens in any browser.

    What was recorded and how well, where the models fail, which effect is missing, what remains, how to do it again.
    Nothing is fetched from a network, so the file can be sent to others. Several models are compared side by side.
    """
    models, recordings = _sorted(files)
    out = out or recordings[0].with_suffix(".report.html")
    inputs = (*models, *recordings, *held_out)
    _refuse_the_same_twice(inputs)
    refuse_existing(out, force=force, read=inputs)

    from ident.output.console.progress import spinner
    from ident.output.report import contents, page

    with spinner() as progress:
        found = contents.gather(contents.ReportRequest(models, recordings, held_out, effect_files, diagnose), progress)
        progress("drawing")
        text = page.render(found)
    _write(text, out)
    click.echo(f"report: {out}", err=True)


def _sorted(files: tuple[Path, ...]) -> tuple[tuple[Path, ...], tuple[Path, ...]]:
    """Models and recordings, by their suffixes."""
    models = tuple(path for path in files if path.suffix == ".json")
    recordings = tuple(path for path in files if path.suffix == ".mcap")
    for path in files:
        if path not in (*models, *recordings):
            raise BadInput(f"{path}: a model (.json) or a recording (.mcap) expected, found something else")
    if not models or not recordings:
        lacking = "model (.json)" if not models else "recording (.mcap)"
        raise BadInput(f"at least one model (.json) and one recording (.mcap) expected, no {lacking} found; add it")
    return models, recordings


def _refuse_the_same_twice(inputs: tuple[Path, ...]) -> None:
    for path in inputs:
        if sum(path.resolve() == other.resolve() for other in inputs) > 1:
            raise BadInput(f"each file once expected, {path} found twice; leave one out")


def _write(text: str, out: Path) -> None:
    """The whole file, or nothing."""
    partial = out.with_name(out.name + ".part")
    try:
        partial.write_text(text, encoding="utf-8")
        partial.replace(out)
    except OSError as error:
        raise BadInput(f"{out} cannot be written: {error.strerror}; choose another place") from None
    finally:
        partial.unlink(missing_ok=True)
