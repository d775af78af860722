"""A diagnosis on the screen."""

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from ident.diagnosis.document import Document, FindingEntry, StepEntry, LearnedCurveEntry, ParameterValue

_COLOURS = {"adequate": "green", "missing-effect": "yellow", "unknown-structure": "magenta"}


def show(document: Document, console: Console) -> None:
    """Print everything a person needs."""
    console.print(document.verdict, style=f"bold {_COLOURS[document.verdict]}", end=": ")
    _say(console, document.sentence)
    if document.simulated:
        console.print("SIMULATED data.", style="bold yellow")
    for caution in document.cautions:
        _say(console, f"Caution: {caution}")
    console.print(_ladder(document))
    _say(console, f"Held out: {document.held_out}. Low-pass {document.bandwidth_hz:g} Hz.")
    for finding in document.findings:
        _finding(finding, document, console)
    if document.findings:
        console.print("In brackets: 95 % intervals, of noise and encoder steps, if the model is right.", style="dim")
    if document.remaining.why:
        _say(console, f"What remains: {document.remaining.why}")
    if document.stand_in:
        _stand_in(document, document.stand_in, console)
    console.print(_rejected(document))
    if document.next_motion:
        # Never wrapped, so that it can be copied.
        _say(console, f"Next: {document.next_motion.why}")
        console.print(f"  {document.next_motion.command}", markup=False, highlight=False, soft_wrap=True)


def _say(console: Console, text: str) -> None:
    """As it is: a user's effect may have brackets in its texts."""
    console.print(text, markup=False, highlight=False)


def _ladder(document: Document) -> Table:
    unit = document.effort_units[0]
    table = Table(title=f"RMS error [{unit}], training | held out", title_justify="left")
    table.add_column("model")
    for joint in document.joints:
        table.add_column(joint, justify="right")
    for label, rung in zip(document.labels, document.rungs, strict=True):
        table.add_row(label, *_errors(rung))
    table.add_section()
    table.add_row("noise floor, with encoder steps", *(f"{value:.3g}" for value in document.noise_rms), style="green")
    table.add_row("measured torque", *(f"{value:.3g}" for value in document.torque_rms), style="dim")
    return table


def _errors(rung: StepEntry) -> list[str]:
    return [f"{seen:.3g} | {held:.3g}" for seen, held in zip(rung.train_rms, rung.validate_rms, strict=True)]


def _finding(finding: FindingEntry, document: Document, console: Console) -> None:
    other = f"  (or: {', '.join(finding.confusable_with)})" if finding.confusable_with else ""
    already = "  (in the model already)" if finding.in_model else ""
    console.print(f"\n{finding.effect}", style="bold", markup=False, highlight=False, end="")
    _say(console, f"{already}{other}")
    _say(console, f"  {finding.sentence} {finding.looks}")
    _say(console, f"  {finding.why}")
    if finding.status == "not-supported":
        return
    own = {name: value for name, value in document.rungs[-1].parameters.items() if is_parameter_of(name, finding.effect)}
    for name, value in own.items():
        amount = "never" if value.infinite else f"{value.value:.4g}{_interval(value)} {value.unit}"
        _say(console, f"  {name} = {amount}  {value.meaning}")
    _say(console, f"  Usual causes: {finding.causes}.\n  What to do: {finding.remedy}.")


def _stand_in(document: Document, found: LearnedCurveEntry, console: Console) -> None:
    joints = ",".join(map(str, found.joints))
    pairs = zip(document.rungs[-1].validate_rms, found.validate_rms, strict=True)
    fell = ", ".join(f"{before:.3g} to {after:.3g}" for before, after in pairs) + f" {document.effort_units[0]}"
    console.print(
        f"Stand-in: curves over {', '.join(found.over)} for joint {joints}, in {found.file}, take away "
        f"{found.gain:.0%} of that on rows no fit has seen (RMS, joint by joint: {fell}).\n"
        f"  {found.command}",
        markup=False,
        highlight=False,
        soft_wrap=True,
    )


def is_parameter_of(parameter: str, effect: str) -> bool:
    """Whether the `parameter` of a model is one of the `effect`'s."""
    return parameter.partition(".")[0].partition("#")[0] == effect


def _interval(value: ParameterValue) -> str:
    return f" ({value.ci95[0]:.4g} to {value.ci95[1]:.4g})" if value.ci95 else ""


def _rejected(document: Document) -> Table:
    table = Table(title="Not added", title_justify="left")
    for column in ("effect", "status", "why"):
        table.add_column(column)
    hopeless = [one for one in document.rejected if one.hopeless]
    for one in document.rejected:
        if one not in hopeless:
            table.add_row(escape(one.effect), one.status, escape(one.why))
    if hopeless:
        names = ", ".join(one.effect for one in hopeless)
        table.add_row(
            "others", "not-supported", escape(f"They would explain next to nothing of what is left: {names}.")
        )
    return table
