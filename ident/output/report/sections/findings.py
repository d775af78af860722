"""Section with the effects that the base model lacks."""

from collections.abc import Iterator

from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import Document, FindingEntry, joint_numbers
from ident.diagnosis.document.findings import merge_repeated
from ident.diagnosis.document.result import DiagnosisResult
from ident.diagnosis.ripple.ripple import EFFECT
from ident.diagnosis.search.selection import Finding
from ident.output.console.diagnosis import is_parameter_of
from ident.output.figures.finding import before_after
from ident.output.figures.order_spectrum import order_spectrum
from ident.output.figures.theme import percent
from ident.output.report.blocks import Card, Notes, Plot, ReportBlock, ReportSection, ReportTable, Text
from ident.output.report.sections import parameter_values


def section(result: DiagnosisResult) -> ReportSection:
    """Return every effect found, with its evidence."""
    diagnosis, document = result.diagnosis, result.document
    below = {finding.term.name: finding for finding in merge_repeated(diagnosis.selection.findings)}
    # Effects that every machine of this kind has come last: they are no findings.
    entries = sorted(document.findings, key=lambda entry: diagnosis.library[entry.effect].mandatory)
    blocks: list[ReportBlock] = [
        _card(index, diagnosis, document, entry, below.get(entry.effect)) for index, entry in enumerate(entries, 1)
    ]
    if not blocks:
        blocks.append(Text(("No effect was found.",)))
    for likely in document.likely:
        blocks.append(Text((f"Likely: {likely.effect} ({joint_numbers(likely.joints)}). {likely.why}",)))
    return ReportSection("findings", "Findings", tuple(blocks))


def _card(index: int, diagnosis: Diagnosis, document: Document, entry: FindingEntry, finding: Finding | None) -> Card:
    effect = diagnosis.library[entry.effect]
    location = "whole robot" if effect.whole_robot else joint_numbers(entry.joints)
    tags = [location, *_share(entry)]
    if effect.mandatory:
        tags.append("always included")
    tags += [f"or: {alternative}" for alternative in entry.confusable_with]
    notes = Notes(
        (
            f"Symptom: {entry.symptom}",
            f"Evidence: {entry.why}",
            f"Usual causes: {entry.causes}.",
            f"What to do: {entry.remedy}.",
            f"Equation: {effect.equation}",
        )
    )
    plots = []
    if finding:
        caption = f"Residual without {entry.effect} and with it; dots are samples, lines their means."
        plots.append(Plot(f"finding-{index}", before_after(diagnosis, finding), caption))
    if entry.effect == EFFECT and diagnosis.ripple.lines:
        caption = "Amplitude above the low-pass over the periods per turn, without the lines and with them."
        plots.append(Plot(f"finding-{index}-orders", order_spectrum(diagnosis.ripple), caption))
    return Card(entry.effect, tuple(tags), (Text((entry.sentence,)), *plots, notes, *_parameters(document, entry)))


def _share(entry: FindingEntry) -> Iterator[str]:
    if entry.share is not None:
        yield f"{percent(entry.share)} of the first model's held-out error above the noise floor"


def _parameters(document: Document, entry: FindingEntry) -> tuple[ReportTable, ...]:
    top = document.steps[-1].parameters
    parameters = {name: value for name, value in top.items() if is_parameter_of(name, entry.effect)}
    return (parameter_values.table(parameters),) if parameters else ()
