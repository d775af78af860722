"""Section with measured and computed torque over time."""

from ident.diagnosis.document.result import DiagnosisResult
from ident.output.figures import theme, torque
from ident.output.figures.theme import percent
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection
from ident.output.report.contents import ReportContents

BUDGET = 3_000_000
"""Size of these plots in the page [bytes]; the whole page stays well below 10 MB."""
_POINT = 8 * 4 / 3
"""Size of a point [bytes]: two single precision numbers in base64."""
_ZOOM = "Drag to zoom (all joints follow), double click for the whole recording."


def before_and_after(result: DiagnosisResult) -> ReportSection:
    """Return the torque of the first and the last model of a diagnosis; the first recording held out is open."""
    split = result.diagnosis.split
    open_index = next((i for i, rows in enumerate(split.train) if not rows.any()), 0)
    points = _points(sum(5 * data.torque.shape[1] for data in split.recordings))
    blocks: list[ReportBlock] = []
    for number, data in enumerate(split.recordings):
        caption = (
            f"Measured torque, and that of the first and the last model; below it what each leaves, low-pass "
            f"{data.bandwidth:g} Hz. {_ZOOM} {_detail(len(data.time), points)}"
        )
        plot = Plot(f"before-after-{number + 1}", torque.before_and_after(result.diagnosis, number, points), caption)
        title = data.recording.path.name + (", held out" if not split.train[number].any() else "")
        blocks.append(Fold(title, (plot,), open=number == open_index))
    return ReportSection("before-after", "Torque before and after", tuple(blocks))


def section(contents: ReportContents) -> ReportSection:
    """Return every recording over time; the first one held out is open, unless a diagnosis shows it."""
    open_index = len(contents.request.recordings) if contents.held_out_analyses else 0
    traces = sum(
        len(prediction.prepared.torque[0]) * (1 + 2 * len(group)) for group, _, prediction in contents.predictions
    )
    points = _points(traces)
    blocks: list[ReportBlock] = []
    for number, (group, index, prediction) in enumerate(contents.predictions):
        prepared = prediction.prepared
        caption = (
            f"Measured and computed torque, and below it the residual, low-pass {prepared.bandwidth:g} Hz. {_ZOOM} "
            f"{_detail(len(prepared.time), points)}"
        )
        plot = Plot(f"torque-{number + 1}", torque.over_time(group, index, points), caption)
        suffix = ", held out" if group is contents.held_out_analyses else ""
        is_open = number == open_index and not contents.diagnosis
        blocks.append(Fold(f"{prepared.recording.path.name}{suffix}", (plot,), open=is_open))
    return ReportSection("torque", "Torque: measured against model", tuple(blocks))


def _points(traces: int) -> int:
    """Return the number of points per trace at which so many `traces` keep to the budget."""
    return max(theme.MAX_POINTS, int(BUDGET / _POINT / traces))


def _detail(rows: int, points: int) -> str:
    if rows <= points:
        return "Every sample is drawn."
    return (
        f"Every sample of the first repetition is drawn; of the rest the extremes, {percent(points / rows)}, so that "
        "no peak is lost."
    )
