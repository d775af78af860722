"""Sections with the unexplained residual and the next recording."""

from collections.abc import Iterator

from ident.diagnosis.document import Document
from ident.output.figures import unexplained_residual
from ident.output.figures.theme import percent
from ident.output.report.blocks import Code, Plot, ReportBlock, ReportSection, Text
from ident.output.report.contents import ReportContents
from recordings.rig import is_default

_CAPTION = (
    "Noise, effect of encoder steps, and structured residual of all rows (their squares add up), beside the error on "
    "rows held out."
)


def remaining(contents: ReportContents) -> ReportSection | None:
    """Return the residual of the last model; None without a diagnosis."""
    diagnosis, document = contents.diagnosis, contents.document
    if diagnosis is None or document is None:
        return None
    summary = document.remaining
    sentences = (
        f"{summary.why[0].upper()}{summary.why[1:]}",
        f"{percent(summary.structured_share)} of the remaining mean square is structured, the rest is noise.",
    )
    blocks: list[ReportBlock] = [
        Text(sentences),
        Plot("unexplained", unexplained_residual.rms_components(diagnosis, document), _CAPTION),
        Plot(
            "unexplained-curves",
            unexplained_residual.residual_curves(diagnosis, document),
            "Residual of the last model over the quantities that it may depend on.",
        ),
    ]
    return ReportSection("remains", "Unexplained residual", tuple(blocks))


def next_recording(contents: ReportContents) -> ReportSection | None:
    """Return the next motion to record; None without a diagnosis."""
    document = contents.document
    if document is None:
        return None
    lines = tuple(_reasons(document))
    blocks: list[ReportBlock] = [Text(lines)]
    if document.next_motion:
        rig = "" if is_default(contents.recordings[0].rig) else " --rig RIG.toml"
        blocks.append(Code((document.next_motion.command, f"daq record --traj next.toml{rig}")))
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
