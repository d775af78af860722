"""`ident diagnose`: which physical effect is missing."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.command_options import CUTOFF, EFFECT_FILES, PREPROCESS
from recordings.command_line import check_readable, refuse_existing, repeated, say_next
from recordings.errors import BadInput
from recordings.next_command import diagnosis, free_name, free_output

if TYPE_CHECKING:
    from ident.diagnosis.document.document import Document

FILE = click.Path(path_type=Path)


@click.command(
    short_help="Find the physical effects that the model lacks.",
    epilog="Example: ident diagnose fig5a.mcap --validate fig5b.mcap --apply -o better.model.json",
)
@click.argument("files", metavar="FILE...", nargs=-1, required=True, type=FILE)
@click.option(
    "--validate",
    multiple=True,
    type=FILE,
    metavar="FILE",
    help="Validate on this recording of another motion: no fit uses it, but it chooses the effects. May be repeated.",
)
@click.option("--model", "model_path", type=FILE, metavar="MODEL", help="Start from the effects of this model.")
@EFFECT_FILES
@PREPROCESS
@CUTOFF
@click.option(
    "--only",
    multiple=True,
    metavar="EFFECT",
    help="Add this effect even if it explains nothing, and no others but those that every such robot has. May be "
    "repeated.",
)
@click.option(
    "--without", multiple=True, metavar="EFFECT", help="Leave this effect out of the library. May be repeated."
)
@click.option("--apply", is_flag=True, help="Write a model with all effects found.")
@click.option("-o", "--out", type=FILE, metavar="FILE", help="Model file.  [default: first FILE's name, .model.json]")
@click.option(
    "--learn",
    "learned_curve",
    type=FILE,
    metavar="FILE",
    help="Write curves for the unexplained residual as an effect file (.py), if held-out rows confirm them.",
)
@click.option(
    "--report",
    type=FILE,
    metavar="HTML",
    help="Page with figures.  [default: first FILE's name, .diagnose.html; none with --json]",
)
@click.option("--force", is_flag=True, help="Replace an existing model, page and effect file.")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON document instead of tables.")
def command(
    files: tuple[Path, ...],
    validate: tuple[Path, ...],
    model_path: Path | None,
    effect_files: tuple[Path, ...],
    preprocess: str,
    cutoff: float | None,
    only: tuple[str, ...],
    without: tuple[str, ...],
    apply: bool,
    out: Path | None,
    learned_curve: Path | None,
    report: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Find the physical effects that the model of the recordings FILE lacks, with the evidence.

    Fits the base model, tries every effect of the library (ident effects) together with all parameters of the model,
    and adds the one that explains most. Repeats this until the residual is noise, or until no effect of the library
    explains the rest.
    """
    _check_options(apply, out, learned_curve)
    out = (out or files[0].with_suffix(".model.json")) if apply else None
    report = report or (None if as_json else files[0].with_suffix(".diagnose.html"))
    start_files = [model_path] if model_path else []
    read = [*files, *validate, *effect_files, *start_files]
    check_readable(*files, *validate, *start_files)
    _check_output_paths([path for path in (out, report, learned_curve) if path], force, read)

    import json
    from dataclasses import replace

    from rich.console import Console

    import ident
    from ident.diagnosis.document import verdict
    from ident.output.console import diagnosis as console_table
    from recordings.progress import progress_bar

    start = ident.load_model(model_path, effect_files) if model_path else None
    with progress_bar("reading") as progress:
        result = ident.diagnose(
            files,
            validate,
            model=start,
            effect_files=() if start else effect_files,
            preprocessing=preprocess,
            cutoff=cutoff,
            only=only,
            without=without,
            progress=progress,
        )
        if learned_curve:
            progress("learning curves for the unexplained residual")
            curves = verdict.write_learned_curve(result.diagnosis, learned_curve)
            result = replace(result, document=result.document.model_copy(update={"learned_curve": curves}))
        if out:
            result.apply().save(out)
        if report:
            from ident.output.report import contents, page

            progress("drawing")
            request = contents.ReportRequest((), files, validate, effect_files, diagnose=True, base_model=model_path)
            page.write(contents.assemble(request, diagnosis=result), report)
    if as_json:
        click.echo(json.dumps(result.as_json(), indent=2, allow_nan=False))
    else:
        console_table.show(result.document, Console())
        if learned_curve and not result.document.learned_curve:
            click.echo(f"{learned_curve} not written: no curve explains the residual on rows that were not fitted.")
    for label, written_path in (("model", out), ("report", report)):
        if written_path:
            click.echo(f"{label}: {written_path}", err=True)
    recorded = [*repeated("--validate", validate), *repeated("--effect-file", effect_files)]
    choices = [*repeated("--model", start_files), *repeated("--only", only), *repeated("--without", without)]
    choices += ["--preprocess", preprocess] if preprocess != "parallel" else []
    choices += ["--cutoff", f"{cutoff:g}"] if cutoff else []
    if result.document.next_motion:
        click.echo(f"next: {result.document.next_motion.command}", err=True)
    else:
        say_next(*_next(result.document, files, recorded, choices, out or model_path, applied=apply))


def _next(
    document: Document,
    files: Sequence[Path],
    recorded: Sequence[str],
    choices: Sequence[str],
    model: Path | None,
    applied: bool,
) -> list[object]:
    """The command that follows from the verdict: add, learn, repeat, or report.

    recorded: options that name further files; choices: those that make this diagnosis what it is.
    """
    default = files[0].with_suffix(".model.json")
    if document.verdict == "implausible-data":
        return ["ident", "check", *files]
    if not applied and document.findings and document.verdict == "missing-effect":
        return diagnosis(files, *recorded, *choices, model=model or default)
    if not applied and document.verdict == "unknown-structure" and not document.learned_curve:
        return diagnosis(files, *recorded, *choices, "--learn", free_name(Path("learned.py")))
    if not applied and document.verdict == "undetermined":
        return ["daq", "record", "--traj", "TRAJECTORY", "--cycles", 3]
    if model:
        page = free_output("-o", files[0].with_suffix(".report.html"))
        return ["ident", "report", model, *files, *recorded, *page]
    return ["ident", "fit", *files, *recorded, *free_output("-o", default)]


def _check_output_paths(paths: Sequence[Path], force: bool, read: Sequence[Path]) -> None:
    """Check output paths before the work, not after it."""
    refuse_existing(*paths, force=force, read=read)
    for path in paths:
        if not path.parent.is_dir():
            raise BadInput(f"folder {path.parent} does not exist; create it, or choose another name than {path}")
        if path.is_dir():
            raise BadInput(f"{path}: a file's name expected, a folder found; choose another name")


def _check_options(apply: bool, out: Path | None, learned_curve: Path | None) -> None:
    if out and not apply:
        raise BadInput(f"--apply expected beside --out {out}, not found; without it no model is written")
    if learned_curve and learned_curve.suffix != ".py":
        raise BadInput(f"--learn {learned_curve}: a name that ends in .py expected; it becomes an effect file")
