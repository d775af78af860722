"""Summary of the report in two or three sentences, with warnings about its numbers."""

from collections.abc import Iterator
from dataclasses import dataclass

from ident.diagnosis.document.document import Document
from ident.output.assessment import data_warnings, warning_lines
from ident.output.digits import number, percent
from ident.output.report.contents import ReportContents

VERDICTS = {
    "adequate": "Nothing is missing",
    "missing-effect": "An effect is missing",
    "unknown-structure": "An unknown effect remains",
    "undetermined": "Nothing was found, but more may be missing",
}


@dataclass(frozen=True)
class Tile:
    """One large number."""

    label: str
    value: str
    note: str


@dataclass(frozen=True)
class Headline:
    """The top of the report."""

    verdict: str
    """Name of the style: a verdict or "none"."""
    title: str
    sentences: tuple[str, ...]
    tiles: tuple[Tile, ...]
    warnings: tuple[str, ...]


def headline(contents: ReportContents) -> Headline:
    """Return title, sentences, key numbers and warnings."""
    warnings = tuple(_warnings(contents))
    if not contents.diagnosis:
        return Headline("none", "Models against measurement", tuple(_comparison_sentences(contents)), (), warnings)
    document = contents.diagnosis.document
    title, sentence = nothing_more_is_missing(contents) or (VERDICTS[document.verdict], document.sentence)
    motion = (document.next_motion.why,) if document.next_motion else ()
    sentences = (sentence, *motion)
    return Headline(document.verdict, title, sentences, tuple(_tiles(document)), warnings)


def nothing_more_is_missing(contents: ReportContents) -> tuple[str, str] | None:
    """Title and sentence on the models that have all effects the base model lacks; None if there are none."""
    if contents.diagnosis is None or contents.diagnosis.verdict != "missing-effect":
        return None
    document, library = contents.diagnosis.document, contents.diagnosis.diagnosis.library
    missing = [finding.effect for finding in document.findings]
    complete = [name for name, model in contents.models.items() if set(missing) <= set(model.effects)]
    if not complete:
        return None
    effects = [name for name in missing if name not in library or not library[name].mandatory]
    have = "has" if len(complete) == 1 else "have"
    return (
        "Nothing more is missing",
        f"{' and '.join(complete)} {have} what the base model lacks, {', '.join(effects)}; with it, no structured "
        "residual is left above the noise floor.",
    )


def _floor(document: Document, joint: int) -> str:
    """Return the noise floor in words."""
    return f"{number(document.noise_rms[joint], 2)}\u00a0{document.effort_units[joint]}"


def _tiles(document: Document) -> Iterator[Tile]:
    base, top = document.steps[0], document.steps[-1]
    for joint, unit in enumerate(document.effort_units):
        before, after = base.held_out_rms[joint], top.held_out_rms[joint]
        share = after / document.torque_rms[joint] if document.torque_rms[joint] else None
        value = number(after, 2) if len(document.steps) == 1 else f"{number(before, 2)} → {number(after, 2)}"
        note = f"{percent(share)} of the torque; noise floor {_floor(document, joint)}"
        yield Tile(f"joint {joint + 1}: held-out error [{unit} RMS]", value, note)


def _comparison_sentences(contents: ReportContents) -> Iterator[str]:
    several = len(contents.primary_analyses) > 1
    for name, analysis in contents.primary_analyses.items():
        yield from (f"{name}: {line}" if several else line for line in analysis.sentences[:3])
    if not any(analysis.test and analysis.test.diagnosed for analysis in contents.primary_analyses.values()):
        yield "Missing effects were not searched for: ident diagnose finds them."


def _warnings(contents: ReportContents) -> Iterator[str]:
    yield from data_warnings(contents.sources, contents.recordings)
    if any(model.relative for model in contents.models.values()):
        yield "The torque gain is assumed, not calibrated: torques and parameters are RELATIVE, up to one factor."
    for name, model in contents.models.items():
        for line in warning_lines(model.assessment, certain=True) if model.assessment else ():
            yield f"{name}: {line}" if len(contents.models) > 1 else line
    share = contents.diagnosis.diagnosis.excerpt_share if contents.diagnosis else None
    if share is not None:
        yield f"Long recordings: the diagnosis used excerpts, {percent(share)} of them."
