"""Sections of a comparison of models with recordings: torque over time, and where the models fail."""

from dataclasses import replace

from ident.output.figures import quality, residuals, spectrum, torque
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection, Text
from ident.output.report.contents import ReportContents
from ident.output.report.detail import ZOOM, detail, points
from ident.output.tables.residuals import summary, windows


def over_time(contents: ReportContents) -> ReportSection:
    """Return every recording over time; the first one held out is open, unless a diagnosis shows it."""
    open_index = len(contents.request.recordings) if contents.held_out_analyses else 0
    # NumPy's first row has one entry for each joint: its measured torque, and two traces of each model.
    count = points(
        sum(len(each.prepared.torque[0]) * (1 + 2 * len(group)) for group, _, each in contents.predictions)
    )
    blocks = []
    for number, (group, index, prediction) in enumerate(contents.predictions):
        prepared = prediction.prepared
        caption = (
            f"Measured and computed torque, and below it the residual, low-pass {prepared.bandwidth:g} Hz. {ZOOM} "
            f"{detail(len(prepared.time), count)}"
        )
        plot = Plot(f"torque-{number + 1}", torque.over_time(group, index, count), caption)
        suffix = ", held out" if group is contents.held_out_analyses else ""
        is_open = number == open_index and not contents.diagnosis
        blocks.append(Fold(f"{prepared.recording.path.name}{suffix}", (plot,), open=is_open))
    return ReportSection("torque", "Torque: measured against model", tuple(blocks))


def failures(contents: ReportContents) -> ReportSection:
    """Return phases, worst windows, dependence on each quantity, and spectrum."""
    analyses = contents.primary_analyses
    several = len(analyses) > 1
    sentences = [
        f"{f'{name}: ' if several else ''}{line}"
        for name, analysis in analyses.items()
        for line in analysis.sentences
    ]
    blocks: list[ReportBlock] = [
        Notes(tuple(sentences)),
        Plot(
            "phases",
            residuals.phases(analyses),
            "Residual by phase of the motion; above each bar the phase's share of the joint's squared residual.",
        ),
        Plot(
            "curves",
            residuals.curves(analyses),
            "Mean residual over each quantity. A correct model leaves a straight line at zero; each title gives the "
            "share of the joint's squared residual that the curve explains without refitting the model (with several "
            "models, for the first). The sentences above have the mechanism's parameters refitted.",
        ),
        Plot(
            "spectrum",
            spectrum.densities(analyses),
            "Spectra of measured torque and residual in all rows, those near standstill too, and of what differs "
            "between repetitions. The noise floor of the tables holds the steps of encoders as well, which repeat.",
        ),
    ]
    for index, (name, analysis) in enumerate(analyses.items(), start=1):
        if analysis.windows:
            caption = "The worst intervals of a quarter of a second, shaded."
            plot = Plot(f"worst-{index}", torque.worst_windows(analysis), caption)
            label = f"Worst intervals{f', {name}' if several else ''}"
            is_open = index == 1 and not analysis.within_noise
            blocks.append(Fold(label, (plot, windows(analysis)), open=is_open))
    within = all(analysis.within_noise for analysis in analyses.values())
    return ReportSection("where", "What is left: noise" if within else "Where the model fails", tuple(blocks))


def noise(contents: ReportContents) -> tuple[ReportBlock, ...]:
    """Return the residual of each joint beside its noise floor, where the motion is repeated also by components."""
    analyses = contents.primary_analyses
    table = summary(analyses)
    scope = "the recordings held out" if contents.held_out_analyses else "all recordings"
    table = replace(table, caption=f"Residual: measured minus computed, in {scope}. {table.caption}")
    if all(joint.noise_rms is None for analysis in analyses.values() for joint in analysis.joints):
        return table, Text(("No motion is repeated in these recordings, so their noise floor is unknown.",))
    return table, Plot("split", quality.mean_square_shares(analyses), "Components of the residual's mean square.")
