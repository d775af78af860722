"""Sections about the recordings: quality of the data, rig and runs."""

from ident.output.figures import quality
from ident.output.report.blocks import Fold, Plot, ReportBlock, ReportSection
from ident.output.report.contents import ReportContents
from ident.output.report.sections.comparison import noise
from ident.output.tables.recordings import side_by_side


def data_quality(contents: ReportContents) -> ReportSection:
    """Return gaps, lateness and noise of all recordings."""
    blocks: list[ReportBlock] = []
    for index, recording in enumerate(contents.recordings, start=1):
        if quality.has_timing(recording):
            caption = f"{recording.path.name}: how late the host began each cycle, and where samples were lost."
            blocks.append(Plot(f"timing-{index}", quality.timing(recording), caption))
    return ReportSection("quality", "Data quality", (*blocks, *noise(contents)))


def rig_and_runs(contents: ReportContents) -> ReportSection:
    """Return the facts and the motion of each recording, and what the models used it for."""
    roles = []
    for index, source in enumerate(contents.sources):
        fitted = [name for name, model in contents.models.items() if source in model.train.recordings]
        held_out = index >= len(contents.request.recordings)
        roles.append(
            "held out" if held_out else f"fitted by {', '.join(fitted)}" if fitted else "not used by the models"
        )
    blocks: list[ReportBlock] = [side_by_side(contents.recordings, {"Role": roles})]
    for index, recording in enumerate(contents.recordings, start=1):
        caption = "The whole run. Click a joint in the legend to hide it."
        plot = Plot(f"motion-{index}", quality.motion(recording), caption)
        blocks.append(Fold(f"The motion in {recording.path.name}", (plot,), open=index == 1))
    return ReportSection("rig", "Rig and run", tuple(blocks))
