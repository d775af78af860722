"""Print a diagnosis."""

from rich.console import Console
from rich.text import Text

from ident.diagnosis.document.document import Document, FindingEntry, FormulaEntry, LearnedCurveEntry, joint_numbers
from ident.output.assessment import scale_line
from ident.output.console.printing import print_command, print_plain, print_simulated, print_table, show_problems
from ident.output.tables import diagnosis

_COLOURS = {
    "adequate": "green",
    "missing-effect": "yellow",
    "unknown-structure": "magenta",
    "undetermined": "cyan",
}
_CRITERION = "Fitted by least squares, as by ident fit --method wls: other methods minimise something else."
_MAX_REJECTED = 5
"""Rows of the table of effects that were not added."""


def show(document: Document, console: Console) -> None:
    """Print what a person would say first, steps of the selection, findings, what is left, and rejected effects."""
    print_simulated(console, document.simulated)
    _print_verdict(console, document.verdict, document.sentence)
    show_problems(document.data_problems, console)
    for warning in document.warnings:
        print_plain(console, f"Warning: {warning}")
    print_table(console, diagnosis.steps(document))
    print_plain(console, f"Held out: {document.held_out}. {_band(document)} {_CRITERION}")
    for finding in document.findings:
        _print_finding(finding, document, console)
    for likely in document.likely:
        print_plain(console, f"\nLikely: {likely.effect} ({joint_numbers(likely.joints)}). {likely.why}")
    if document.findings:
        intervals = "In parentheses: 95 % intervals for noise and quantization, if the model is right."
        console.print(f"{intervals} {scale_line(document.scale_uncertainty, document.relative)}", style="dim")
    if document.remaining.why:
        print_plain(console, f"Unexplained residual: {document.remaining.why}")
    if document.above_low_pass:
        print_plain(console, document.above_low_pass.why)
    if document.remaining.formula:
        _print_formula(document, document.remaining.formula, console)
    if document.learned_curve:
        _print_learned_curves(document, document.learned_curve, console)
    print_table(console, diagnosis.rejected(document, _MAX_REJECTED))
    if document.next_motion:
        print_plain(console, f"Next: {document.next_motion.why}")
        print_command(console, f"  {document.next_motion.command}")
    console.print()
    _print_errors(document, console, f"{document.verdict}. ")


def show_conclusion(document: Document, console: Console, nothing_more: tuple[str, str] | None = None) -> None:
    """Print the verdict with its sentences, and the held-out error of each joint before and after.

    nothing_more: verdict and sentence in place of those of the `document`, on models that have what was found.
    """
    _print_verdict(console, *(nothing_more or (document.verdict, document.sentence)))
    _print_errors(document, console)


def _print_verdict(console: Console, verdict: str, sentence: str) -> None:
    colour = _COLOURS.get(verdict, _COLOURS["adequate"])
    console.print(Text.assemble((verdict, f"bold {colour}"), f": {sentence}"), highlight=False)


def _print_errors(document: Document, console: Console, verdict: str = "") -> None:
    print_plain(console, f"{verdict}Held-out error (RMS), first model → last model:")
    for line in document.error_lines:
        print_plain(console, f"  {line}")


def _band(document: Document) -> str:
    """The frequencies that errors and effects are about."""
    above = document.above_low_pass
    if above is None or above.low_hz == document.bandwidth_hz:
        return f"Low-pass {document.bandwidth_hz:g} Hz."
    return f"Low-pass {above.low_hz:g} Hz; errors are stated up to {document.bandwidth_hz:.0f} Hz, with the ripple."


def _print_finding(finding: FindingEntry, document: Document, console: Console) -> None:
    alternatives = f"  (or: {', '.join(finding.confusable_with)})" if finding.confusable_with else ""
    note = "  (already in the model)" if finding.in_model else ""
    console.print(f"\n{finding.effect}", style="bold", markup=False, highlight=False, end="")
    print_plain(console, f"{note}{alternatives}")
    print_plain(console, f"  {finding.sentence} {finding.symptom}\n  {finding.why}")
    if finding.status == "not-supported":
        return
    for name, value in document.steps[-1].parameters.items():
        if is_parameter_of(name, finding.effect):
            print_plain(console, f"  {name} = {value.in_words}  {value.meaning}")
    print_plain(console, f"  Usual causes: {finding.causes}.\n  What to do: {finding.remedy}.")


def _print_formula(document: Document, formula: FormulaEntry, console: Console) -> None:
    print_plain(console, f"\nFormula on {joint_numbers(formula.joints)}: {formula.text}")
    for name, parameter in formula.parameters.items():
        print_plain(console, f"  {name} = {parameter.in_words}")
    pairs = zip(document.steps[-1].held_out_rms, formula.held_out_rms, strict=True)
    changes = ", ".join(f"{before:.3g} → {after:.3g}" for before, after in pairs)
    print_plain(
        console,
        f"  It takes {formula.explains:.0%} of the held-out mean square above the noise floor that the last model "
        f"leaves (RMS per joint: {changes} {document.effort_units[0]}). Known for {formula.known_for}.",
    )
    if formula.alternatives:
        print_plain(console, f"  These data cannot tell it from: {'; '.join(formula.alternatives)}.")
    if formula.resembles:
        print_plain(console, f"  Of the library it resembles most {formula.resembles}.")


def _print_learned_curves(document: Document, entry: LearnedCurveEntry, console: Console) -> None:
    pairs = zip(document.steps[-1].held_out_rms, entry.held_out_rms, strict=True)
    changes = ", ".join(f"{before:.3g} to {after:.3g}" for before, after in pairs)
    print_command(
        console,
        f"Learned curves over {', '.join(entry.over)} for joint {','.join(map(str, entry.joints))}, in {entry.file}, "
        f"remove {entry.gain:.0%} of the unexplained residual on rows that no fit has used (RMS per joint: {changes} "
        f"{document.effort_units[0]}).\n  {entry.command}",
    )


def is_parameter_of(parameter: str, effect: str) -> bool:
    """Return whether the `parameter` of a model belongs to `effect`."""
    return parameter.partition(".")[0].partition("#")[0] == effect
