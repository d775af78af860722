"""Torque measured against computed."""

from ident.output.figures import theme, torque
from ident.output.figures.theme import percent
from ident.output.report.blocks import ReportBlock, Fold, Plot, ReportSection
from ident.output.report.contents import ReportContents

BUDGET = 3_000_000
"""Bytes of the page for these plots: with Plotly and all else, it stays well below 10 MB."""
_POINT = 8 * 4 / 3
"""Bytes of a point: two single precision numbers in base64."""


def section(material: ReportContents) -> ReportSection:
    """Every recording over time; the first one that was held out is open."""
    opened = len(material.request.recordings) if material.held_out_comparisons else 0
    points = _points(material)
    blocks: list[ReportBlock] = []
    for number, (group, place, found) in enumerate(material.predictions):
        dataset = found.dataset
        caption = (
            f"Measured and computed torque, and below it what is left, low-pass {dataset.bandwidth:g} Hz. Drag to "
            f"zoom (all joints follow), double click for the whole recording. {_detail(len(dataset.time), points)}"
        )
        plot = Plot(f"torque-{number + 1}", torque.over_time(group, place, points), caption)
        held = ", held out" if group is material.held_out_comparisons else ""
        blocks.append(Fold(f"{dataset.recording.path.name}{held}", (plot,), open=number == opened))
    return ReportSection("torque", "Torque: measured against model", tuple(blocks))


def _points(material: ReportContents) -> int:
    """Of each trace, so that all of them together keep to the budget."""
    traces = sum(len(found.dataset.torque[0]) * (1 + 2 * len(group)) for group, _, found in material.predictions)
    return max(theme.MAX_POINTS, int(BUDGET / _POINT / traces))


def _detail(rows: int, points: int) -> str:
    if rows <= points:
        return "Every sample is there."
    return (
        f"Every sample of the first repetition is there; of the rest {percent(points / rows)}, the extremes, so that "
        "no peak is lost."
    )
