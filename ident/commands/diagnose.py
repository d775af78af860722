"""`ident diagnose`: which physical effect is missing."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from ident.command_options import (
    ACCEPT,
    CUTOFF,
    EFFECT_FILES,
    FILE,
    JSON,
    PREPROCESS,
    DataCommand,
    again,
    check_choices,
    check_outputs,
    ends,
    needs,
    say_written,
    show_result,
)
from recordings.command_line import check_readable, output_name, say_next
from recordings.files import free_name
from recordings.next_command import diagnosis

if TYPE_CHECKING:
    from ident.diagnosis.document.document import Document
    from ident.diagnosis.document.result import DiagnosisResult


@click.command(
    cls=DataCommand,
    rules=[
        needs("--out", "--apply", "without it no model is written"),
        ends("--learn", ".py", "a name", "it becomes an effect file"),
        ends("--propose", ".py", "a name", "it becomes an effect file"),
    ],
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
@ACCEPT
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
    "--propose",
    "proposed",
    type=FILE,
    metavar="FILE",
    help="Write a formula for what is left, or in place of an effect with knots, as an effect file (.py), if "
    "held-out rows confirm one.",
)
@click.option(
    "--report",
    type=FILE,
    metavar="HTML",
    help="Page with figures.  [default: first FILE's name, .diagnose.html; none with --json]",
)
@click.option("--force", is_flag=True, help="Replace an existing model, page and effect file.")
@JSON
def command(
    files: tuple[Path, ...],
    validate: tuple[Path, ...],
    model_path: Path | None,
    effect_files: tuple[Path, ...],
    preprocess: str,
    cutoff: float | None,
    only: tuple[str, ...],
    without: tuple[str, ...],
    accept: tuple[str, ...],
    apply: bool,
    out: Path | None,
    learned_curve: Path | None,
    proposed: Path | None,
    report: Path | None,
    force: bool,
    as_json: bool,
) -> None:
    """Find the physical effects that the model of the recordings FILE lacks, with the evidence.

    Fits the base model, tries every effect of the library (ident effects) together with all parameters of the model,
    and adds the one that explains most. Repeats this until the residual is noise, or until no effect of the library
    explains the rest.
    """
    inputs = [*files, *validate, *([model_path] if model_path else [])]
    check_readable(*inputs)
    check_choices((*only, *without), effect_files, accept)
    out = output_name(out, files[0].with_suffix(".model.json"), force) if apply else None
    report = report if as_json else output_name(report, files[0].with_suffix(".diagnose.html"), force)
    check_outputs(out, report, learned_curve, proposed, force=force, read=[*inputs, *effect_files])

    import ident
    from ident.output.console.diagnosis import show
    from recordings.progress import progress_bar

    with progress_bar("reading") as progress:
        start = ident.load_model(model_path, effect_files=effect_files) if model_path else None
        result = ident.diagnose(
            files, validate=validate, model=start, effect_files=() if start else effect_files,
            preprocessing=preprocess, cutoff=cutoff, only=only, without=without, accept=accept, progress=progress,
        )  # fmt: skip
        if learned_curve:
            progress("learning curves for the unexplained residual")
            result = _with_learned_curve(result, learned_curve)
        if proposed:
            progress("searching a formula")
            result = result.with_formula(proposed)
        if not force:  # another run may have taken these names meanwhile
            out, report = (free_name(path) if path else None for path in (out, report))
        if out:
            result.model.save(out, force=force)
        if report:
            progress("drawing")
            _write_report(result, report, files, validate, effect_files, model_path)
    document = result.document
    show_result(as_json, result.as_json, partial(show, document))
    if not as_json:
        _say_not_written(document, learned_curve, proposed)
    say_written(model=out, report=report, formula=proposed if document.remaining.formula else None)
    if document.next_motion:
        click.echo(f"next: {document.next_motion.command}", err=True)
    else:
        say_next(*_next(document, files, out or model_path, applied=apply, proposed=proposed, learned=learned_curve))


def _say_not_written(document: Document, learned_curve: Path | None, proposed: Path | None) -> None:
    if learned_curve and not document.learned_curve:
        click.echo(f"{learned_curve} not written: no curve explains the residual on rows that were not fitted.")
    if proposed and not document.remaining.formula:
        click.echo(f"{proposed} not written: no formula is confirmed on rows that were not fitted.")


def _with_learned_curve(result: DiagnosisResult, path: Path) -> DiagnosisResult:
    """The `result` with the curves that were learned for its unexplained residual, if rows held out confirm them."""
    from dataclasses import replace

    from ident.diagnosis.document.verdict import write_learned_curve

    curves = write_learned_curve(result.diagnosis, path)
    return replace(result, document=result.document.model_copy(update={"learned_curve": curves}))


def _write_report(
    result: DiagnosisResult,
    out: Path,
    files: tuple[Path, ...],
    validate: tuple[Path, ...],
    effect_files: tuple[Path, ...],
    model: Path | None,
) -> None:
    from ident.output.report import contents, page

    request = contents.ReportRequest((), files, validate, effect_files, diagnose=True, base_model=model)
    page.write(contents.assemble(request, diagnosis=result), out)


def _next(
    document: Document,
    files: Sequence[Path],
    model: Path | None,
    *,
    applied: bool,
    proposed: Path | None,
    learned: Path | None,
) -> list[object]:
    """The command that follows from the verdict: add, propose, learn, repeat, or report.

    proposed: the file of the formula that was asked for; learned: that of curves, the last thing to be tried.
    """
    default = files[0].with_suffix(".model.json")
    recorded = again("--validate", "--effect-file")
    choices = again("--model", "--only", "--without", "--accept", "--preprocess", "--cutoff")
    if proposed and document.remaining.formula:
        return diagnosis(files, *recorded, *choices, "--effect-file", proposed, model=model or default)
    if not applied and document.findings and document.verdict == "missing-effect":
        return diagnosis(files, *recorded, *choices, model=model or default)
    if not applied and document.verdict == "unknown-structure" and not learned:
        option, name = ("--learn", "learned.py") if proposed else ("--propose", "law.py")
        return diagnosis(files, *recorded, *choices, option, free_name(Path(name)))
    if not applied and document.verdict == "undetermined":
        return ["daq", "record", "--traj", "TRAJECTORY", "--cycles", 3]
    if model:
        return ["ident", "report", model, *files, *recorded]
    return ["ident", "fit", *files, *recorded]
