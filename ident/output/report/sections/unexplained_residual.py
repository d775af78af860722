"""Sections with the unexplained residual and the next recording."""

from collections.abc import Iterator

from ident.diagnosis.document.document import Document
from ident.diagnosis.document.result import DiagnosisResult
from ident.output.figures import spectrum, unexplained_residual
from ident.output.figures.learned_curves import learned_curves
from ident.output.figures.theme import percent
from ident.output.report.blocks import Code, Plot, ReportBlock, ReportSection, Text
from recordings.next_command import OWN_RIG
from recordings.rig import is_default

_CAPTION = (
    "Noise, effect of quantization, and structured residual of all rows (their squares add up), beside the error on "
    "rows held out."
)


def remaining(result: DiagnosisResult) -> ReportSection:
    """Return the residual of the last model."""
    diagnosis, document = result.diagnosis, result.document
    analysis = unexplained_residual.last_residual(diagnosis)
    summary = document.remaining
    within_noise = document.verdict in ("adequate", "missing-effect")
    structured = f"{percent(summary.structured_share)} of the remaining mean square is structured; the rest is noise."
    sentences = [
        f"{summary.why[0].upper()}{summary.why[1:]}",
        *([] if within_noise else [structured]),
        *([document.above_low_pass.why] if document.above_low_pass else []),
    ]
    blocks: list[ReportBlock] = [
        Text(tuple(sentences)),
        Plot("unexplained", unexplained_residual.rms_components(diagnosis, document), _CAPTION),
        Plot(
            "unexplained-curves",
            unexplained_residual.residual_curves(diagnosis, analysis),
            "Residual of the last model over the quantities that it may depend on.",
        ),
    ]
    if "frequency" in summary.depends_on:
        figure = spectrum.densities({"residual of the last model": analysis})
        blocks.append(Plot("unexplained-spectrum", figure, "Residual of the last model by frequency."))
    if diagnosis.learned:
        figure = learned_curves(diagnosis, diagnosis.learned)
        caption = "Curves learned from the residual over what it depends on, with 95 % bands of its mean."
        blocks.append(Plot("learned", figure, caption))
    return ReportSection("remains", "Unexplained residual", tuple(blocks))


def next_recording(result: DiagnosisResult) -> ReportSection:
    """Return the next motion to record."""
    document = result.document
    lines = tuple(_reasons(document))
    blocks: list[ReportBlock] = [Text(lines)]
    if document.next_motion:
        known = is_default(result.diagnosis.split.recordings[0].recording.rig)
        rig = "" if known else f" --rig RIG.toml  # {OWN_RIG}"
        design = document.next_motion.command
        blocks.append(Code((design, f"daq record --traj {design.split()[-1]}{rig}")))
    return ReportSection("next", "What to record next", tuple(blocks))


def _reasons(document: Document) -> Iterator[str]:
    if document.next_motion:
        yield document.next_motion.why
    else:
        yield "No further motion is needed to separate the findings from other effects."
    untested = [entry.effect for entry in document.rejected if entry.status == "not-tested"]
    if untested:
        yield (
            f"These motions do not excite {', '.join(untested)}; another motion may, such as one from ident design."
        )
