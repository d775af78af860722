"""Section with measured and computed torque over time."""

from ident.output.figures import theme, torque
from ident.output.figures.theme import percent
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection
from ident.output.report.contents import ReportContents

BUDGET = 3_000_000
"""Size of these plots in the page [bytes]; the whole page stays well below 10 MB."""
_POINT = 8 * 4 / 3
"""Size of a point [bytes]: two single precision numbers in base64."""


def section(contents: ReportContents) -> ReportSection:
    """Return every recording over time; the first one held out is open."""
    open_index = len(contents.request.recordings) if contents.held_out_analyses else 0
    points = _points(contents)
    blocks: list[ReportBlock] = []
    for number, (group, index, prediction) in enumerate(contents.predictions):
        prepared = prediction.prepared
        caption = (
            f"Measured and computed torque, and below it the residual, low-pass {prepared.bandwidth:g} Hz. Drag to "
            f"zoom (all joints follow), double click for the whole recording. {_detail(len(prepared.time), points)}"
        )
        plot = Plot(f"torque-{number + 1}", torque.over_time(group, index, points), caption)
        suffix = ", held out" if group is contents.held_out_analyses else ""
        blocks.append(Fold(f"{prepared.recording.path.name}{suffix}", (plot,), open=number == open_index))
    return ReportSection("torque", "Torque: measured against model", tuple(blocks))


def _points(contents: ReportContents) -> int:
    """Return the number of points per trace at which all traces keep to the budget."""
    traces = sum(
        len(prediction.prepared.torque[0]) * (1 + 2 * len(group)) for group, _, prediction in contents.predictions
    )
    return max(theme.MAX_POINTS, int(BUDGET / _POINT / traces))


def _detail(rows: int, points: int) -> str:
    if rows <= points:
        return "Every sample is drawn."
    return (
        f"Every sample of the first repetition is drawn; of the rest the extremes, {percent(points / rows)}, so that "
        "no peak is lost."
    )
