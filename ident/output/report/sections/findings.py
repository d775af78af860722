"""What is missing."""

from ident.diagnosis import answer
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import Document, FindingEntry
from ident.diagnosis.steps import Finding
from ident.output.console import diagnosis
from ident.output.figures import finding
from ident.output.figures.theme import percent
from ident.output.report.blocks import ReportBlock, Card, Notes, Plot, ReportSection, ReportTable, Text
from ident.output.report.contents import ReportContents
from ident.output.report.sections import parameter_values


def section(material: ReportContents) -> ReportSection | None:
    """Every effect that was found, with its evidence; None where nobody asked."""
    found, document = material.diagnosis, material.document
    if found is None or document is None:
        return None
    pairs = list(zip(document.findings, answer.merge_repeated(found.selection.findings), strict=True))
    # What is true of any such machine is no news.
    pairs.sort(key=lambda pair: pair[1].term.effect.always_true)
    blocks: list[ReportBlock] = [_card(place, found, document, *pair) for place, pair in enumerate(pairs, start=1)]
    if not blocks:
        blocks.append(Text(("No effect was found.",)))
    return ReportSection("findings", "Findings", tuple(blocks))


def _card(place: int, found: Diagnosis, document: Document, entry: FindingEntry, one: Finding) -> Card:
    effect = one.term.effect
    where = "whole robot" if effect.whole_robot else f"joint {', '.join(map(str, entry.joints))}"
    low, high = entry.gain_ci95
    tags = [
        where,
        f"explains {percent(entry.gain)} ({100 * low:.3g} to {100 * high:.3g}\u00a0%) of the held-out excess",
    ]
    if effect.always_true:
        tags.append("true of any such machine")
    tags += [f"or: {other}" for other in entry.confusable_with]
    notes = Notes(
        (
            f"How it looks: {entry.looks}",
            f"Evidence: {entry.why}",
            f"Usual causes: {entry.causes}.",
            f"What to do: {entry.remedy}.",
            f"Equation: {effect.equation}",
        )
    )
    caption = f"What is left without {entry.effect} and with it; dots are samples, lines their means."
    plot = Plot(f"finding-{place}", finding.before_after(found, one), caption)
    return Card(entry.effect, tuple(tags), (Text((entry.sentence,)), notes, plot, *_parameters(document, entry)))


def _parameters(document: Document, entry: FindingEntry) -> tuple[ReportTable, ...]:
    top = document.rungs[-1].parameters
    own = {name: value for name, value in top.items() if diagnosis.is_parameter_of(name, entry.effect)}
    return (parameter_values.table(own),) if own else ()
