"""The report in two or three plain sentences, and what must be known before a figure is believed."""

from collections.abc import Iterator
from dataclasses import dataclass

from ident.diagnosis.document import Document
from ident.output.figures.theme import number, percent
from ident.output.report.contents import ReportContents

VERDICTS = {
    "adequate": "Nothing is missing",
    "missing-effect": "An effect is missing",
    "unknown-structure": "Something unknown is left",
}


@dataclass(frozen=True)
class Tile:
    """One large figure."""

    label: str
    value: str
    note: str


@dataclass(frozen=True)
class Headline:
    """The top of the report."""

    verdict: str
    """Name for the style: a verdict, or none."""
    title: str
    sentences: tuple[str, ...]
    tiles: tuple[Tile, ...]
    warnings: tuple[str, ...]


def headline(material: ReportContents) -> Headline:
    """What a reader with half a minute must know."""
    document = material.document
    warnings = tuple(_warnings(material))
    if document:
        known = tuple(_known(material, document))
        sentences = (*known, document.sentence, *_fall(document), *_next(document))
        title = "Nothing more is missing" if known else VERDICTS[document.verdict]
        return Headline(document.verdict, title, sentences, tuple(_tiles(material, document)), warnings)
    return Headline("none", "Models against measurement", tuple(_compared(material)), (), warnings)


def _known(material: ReportContents, document: Document) -> Iterator[str]:
    """Where the model already holds all that the base model lacks."""
    lacking = {one.effect for one in document.findings}
    for name, model in material.models.items():
        if document.verdict == "missing-effect" and lacking <= set(model.effects):
            yield f"{name} holds all that is said below to be missing in the base model."


def _fall(document: Document) -> Iterator[str]:
    """How far the held-out error of the worst joint fell."""
    before, after = document.rungs[0].validate_rms, document.rungs[-1].validate_rms
    joint = before.index(max(before))
    if len(document.rungs) == 1 or not before[joint]:
        return
    unit = document.effort_units[joint].replace(" ", "\u00a0")
    first, last, floor = (number(value, 2) for value in (before[joint], after[joint], document.noise_rms[joint]))
    yield (
        f"On rows that no fit saw, the error of joint {joint + 1} falls from {first} to {last}\u00a0{unit} RMS, by "
        f"{percent(1 - after[joint] / before[joint])}; the noise floor is at {floor}\u00a0{unit}."
    )


def _next(document: Document) -> Iterator[str]:
    if document.next_motion:
        yield document.next_motion.why


def _tiles(material: ReportContents, document: Document) -> Iterator[Tile]:
    base, top = document.rungs[0], document.rungs[-1]
    for joint, unit in enumerate(document.effort_units):
        before, after = base.validate_rms[joint], top.validate_rms[joint]
        share = after / document.torque_rms[joint] if document.torque_rms[joint] else None
        value = number(after, 2) if len(document.rungs) == 1 else f"{number(before, 2)} → {number(after, 2)}"
        note = f"{percent(share)} of the torque; noise floor {number(document.noise_rms[joint], 2)} {unit}"
        yield Tile(f"joint {joint + 1}: held-out error [{unit} RMS]", value, note)


def _compared(material: ReportContents) -> Iterator[str]:
    for name, comparison in material.primary_comparisons.items():
        shares = ", ".join(f"{percent(joint.summary.share)}" for joint in comparison.joints)
        prefix = f"{name} leaves" if len(material.primary_comparisons) > 1 else "The model leaves"
        yield f"{prefix} {shares} of the torque unexplained (joints 1 to {len(comparison.joints)})."
    if len(material.primary_comparisons) == 1:
        yield from next(iter(material.primary_comparisons.values())).sentences[1:3]
    yield "What is missing was not asked for: leave out --no-diagnose to find out."


def _warnings(material: ReportContents) -> Iterator[str]:
    simulated = [source.name for source in material.sources if source.simulated]
    if simulated:
        yield f"SIMULATED data: {', '.join(simulated)}."
    interrupted = [one.path.name for one in material.recordings if not one.complete]
    if interrupted:
        yield f"Interrupted, used as far as it goes: {', '.join(interrupted)}."
    relative = [name for name, model in material.models.items() if model.relative]
    if relative:
        yield "The torque gain is assumed, not calibrated: torques and parameters are RELATIVE, up to one factor."
    if material.diagnosis and material.diagnosis.excerpt_share is not None:
        yield f"Long recordings: the diagnosis looked at {percent(material.diagnosis.excerpt_share)} of them, in excerpts."
