"""Print a diagnosis."""

from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ident.diagnosis.document.document import (
    Document,
    FindingEntry,
    LearnedCurveEntry,
    RejectedEntry,
    StepEntry,
    joint_numbers,
)
from ident.output.console.assessment import scale_line

_COLOURS = {
    "adequate": "green",
    "missing-effect": "yellow",
    "unknown-structure": "magenta",
    "undetermined": "cyan",
    "implausible-data": "red",
}
_MAX_REJECTED = 5
"""Rows of the table of effects that were not added."""
_NOTABLE = 1.25
"""Ratio of the error on all rows to that on scored rows from which both are printed."""


def show(document: Document, console: Console) -> None:
    """Print steps of the selection, findings, unexplained residual, rejected effects, and the conclusion."""
    if document.simulated:
        console.print("SIMULATED data.", style="bold yellow")
    problems = (f"Data problem ({each.kind}): {each.why} {each.remedy}" for each in document.data_problems)
    for line in (*problems, *(f"Warning: {warning}" for warning in document.warnings)):
        _print_plain(console, line)
    console.print(_step_table(document))
    _print_plain(console, f"Held out: {document.held_out}. {_band(document)}")
    for finding in document.findings:
        _print_finding(finding, document, console)
    for likely in document.likely:
        _print_plain(console, f"\nLikely: {likely.effect} ({joint_numbers(likely.joints)}). {likely.why}")
    if document.findings:
        console.print(
            "In parentheses: 95 % intervals for noise and quantization, if the model is right. "
            f"{scale_line(document.scale_uncertainty, document.relative)}",
            style="dim",
        )
    if document.remaining.why:
        _print_plain(console, f"Unexplained residual: {document.remaining.why}")
    if document.above_low_pass:
        _print_plain(console, document.above_low_pass.why)
    if document.learned_curve:
        _print_learned_curves(document, document.learned_curve, console)
    console.print(_rejected_table(document))
    if document.next_motion:
        # Never wrapped, so that it can be copied.
        _print_plain(console, f"Next: {document.next_motion.why}")
        console.print(f"  {document.next_motion.command}", markup=False, highlight=False, soft_wrap=True)
    show_conclusion(document, console)


def show_conclusion(document: Document, console: Console, nothing_more: tuple[str, str] | None = None) -> None:
    """Print verdict, effects with their joints, and the held-out error of each joint before and after.

    nothing_more: verdict and sentence in place of those of the `document`, on models that have what was found.
    """
    verdict, sentence = nothing_more or (document.verdict, document.sentence)
    colour = _COLOURS["adequate" if nothing_more else document.verdict]
    console.print(f"\n{verdict}", style=f"bold {colour}", end=": ")
    _print_plain(console, sentence)
    console.print("Held-out error (RMS), first model → last model:", highlight=False)
    errors = zip(document.steps[0].held_out_rms, document.steps[-1].held_out_rms, strict=True)
    for joint, unit, (before, after) in zip(document.joints, document.effort_units, errors, strict=True):
        _print_plain(console, f"  {joint}  {before:.3g} → {after:.3g} {unit}")


def _print_plain(console: Console, text: str) -> None:
    """Print `text` without markup: a user's effect may have brackets in its texts."""
    console.print(text, markup=False, highlight=False)


def _band(document: Document) -> str:
    """The frequencies that errors and effects are about."""
    above = document.above_low_pass
    if above is None or above.low_hz == document.bandwidth_hz:
        return f"Low-pass {document.bandwidth_hz:g} Hz."
    return f"Low-pass {above.low_hz:g} Hz; errors are stated up to {document.bandwidth_hz:.0f} Hz, with the ripple."


def _step_table(document: Document) -> Table:
    unit = document.effort_units[0]
    table = Table(title=f"RMS error [{unit}], training | held out", title_justify="left")
    table.add_column("model")
    for joint in document.joints:
        table.add_column(joint, justify="right")
    for label, step in zip(document.labels, document.steps, strict=True):
        table.add_row(label, *_rms_cells(step.train_rms, step.held_out_rms))
    table.add_section()
    if _differs_notably(document.steps[-1]):
        last = document.steps[-1]
        table.add_row("last model, on all rows", *_rms_cells(last.train_rms_all, last.held_out_rms_all))
    table.add_row("noise floor, with quantization", *(f"{value:.3g}" for value in document.noise_rms), style="green")
    table.add_row("measured torque", *(f"{value:.3g}" for value in document.torque_rms), style="dim")
    return table


def _rms_cells(train_rms: Sequence[float], test_rms: Sequence[float]) -> list[str]:
    return [f"{train:.3g} | {test:.3g}" for train, test in zip(train_rms, test_rms, strict=True)]


def _differs_notably(step: StepEntry) -> bool:
    """Whether the error on all rows is notably larger than on those that are scored."""
    pairs = zip((*step.train_rms_all, *step.held_out_rms_all), (*step.train_rms, *step.held_out_rms), strict=False)
    return any(on_all > _NOTABLE * scored for on_all, scored in pairs)


def _print_finding(finding: FindingEntry, document: Document, console: Console) -> None:
    alternatives = f"  (or: {', '.join(finding.confusable_with)})" if finding.confusable_with else ""
    note = "  (already in the model)" if finding.in_model else ""
    console.print(f"\n{finding.effect}", style="bold", markup=False, highlight=False, end="")
    _print_plain(console, f"{note}{alternatives}")
    _print_plain(console, f"  {finding.sentence} {finding.symptom}")
    _print_plain(console, f"  {finding.why}")
    if finding.status == "not-supported":
        return
    parameters = {
        name: value for name, value in document.steps[-1].parameters.items() if is_parameter_of(name, finding.effect)
    }
    for name, value in parameters.items():
        _print_plain(console, f"  {name} = {value.in_words}  {value.meaning}")
    _print_plain(console, f"  Usual causes: {finding.causes}.\n  What to do: {finding.remedy}.")


def _print_learned_curves(document: Document, entry: LearnedCurveEntry, console: Console) -> None:
    joints = ",".join(map(str, entry.joints))
    pairs = zip(document.steps[-1].held_out_rms, entry.held_out_rms, strict=True)
    changes = ", ".join(f"{before:.3g} to {after:.3g}" for before, after in pairs) + f" {document.effort_units[0]}"
    console.print(
        f"Learned curves over {', '.join(entry.over)} for joint {joints}, in {entry.file}, remove "
        f"{entry.gain:.0%} of the unexplained residual on rows that no fit has used (RMS per joint: {changes}).\n"
        f"  {entry.command}",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )


def is_parameter_of(parameter: str, effect: str) -> bool:
    """Return whether the `parameter` of a model belongs to `effect`."""
    return parameter.partition(".")[0].partition("#")[0] == effect


def _is_screened(entry: RejectedEntry) -> bool:
    """Whether screening alone ruled it out: it would explain hardly more than chance."""
    return entry.evidence is not None and entry.evidence.decided_by == "screening"


def _gain(entry: RejectedEntry) -> float:
    return entry.evidence.gain if entry.evidence else 0.0


def _rejected_table(document: Document) -> Table:
    table = Table(title="Not added", title_justify="left")
    for column in ("effect", "status", "why"):
        table.add_column(column)
    ranks = {"absorbed": 0, "not-confirmed": 1, "refuted": 2, "not-tested": 3, "not-observable": 4}
    ranked = sorted(document.rejected, key=lambda entry: (_is_screened(entry), ranks[entry.status], -_gain(entry)))
    for entry in ranked[: _MAX_REJECTED - 1]:
        table.add_row(escape(entry.effect), entry.status, escape(entry.why))
    if others := ranked[_MAX_REJECTED - 1 :]:
        table.add_row(f"{len(others)} others", "", "The report and --json list them with the reasons.")
    return table
