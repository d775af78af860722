"""What remains, and what to record next."""

from collections.abc import Iterator

from ident.diagnosis.document import Document
from ident.output.figures import unexplained_residual
from ident.output.figures.theme import percent
from ident.output.report.blocks import ReportBlock, Code, Plot, ReportSection, Text
from ident.output.report.contents import ReportContents
from recordings.rig import is_default

_CAPTION = (
    "Noise, what encoder steps leave, and what is structured in all rows (their squares add up), beside the error on "
    "rows held out."
)


def remaining(material: ReportContents) -> ReportSection | None:
    """What the last model leaves; None where nobody asked."""
    found, document = material.diagnosis, material.document
    if found is None or document is None:
        return None
    left = document.remaining
    sentences = (
        f"{left.why[0].upper()}{left.why[1:]}",
        f"{percent(left.structured_share)} of the remaining mean square is structured, the rest is noise.",
    )
    blocks: list[ReportBlock] = [
        Text(sentences),
        Plot("remainder", unexplained_residual.rms_components(found, document), _CAPTION),
        Plot("left", unexplained_residual.residual_curves(found, document), "What the last model leaves, over what it may depend on."),
    ]
    return ReportSection("remains", "What remains", tuple(blocks))


def next_recording(material: ReportContents) -> ReportSection | None:
    """What to record next; None where nobody asked."""
    document = material.document
    if document is None:
        return None
    lines = tuple(_reasons(document))
    blocks: list[ReportBlock] = [Text(lines)]
    if document.next_motion:
        rig = "" if is_default(material.recordings[0].rig) else " --rig RIG.toml"
        blocks.append(Code((document.next_motion.command, f"daq record --traj next.toml{rig}")))
    return ReportSection("next", "What to record next", tuple(blocks))


def _reasons(document: Document) -> Iterator[str]:
    if document.next_motion:
        yield document.next_motion.why
    else:
        yield "Nothing is needed to tell the findings from other effects."
    untested = [one.effect for one in document.rejected if one.status == "not-tested"]
    if untested:
        yield (
            f"These motions do not show {', '.join(untested)}; another one may, such as one that ident design finds."
        )
