"""Sections on models and recordings: torque over time, where models fail, parameters, data quality, rig and runs."""

from dataclasses import replace

from ident.output.assessment import summary_lines
from ident.output.figures import parameters as figures
from ident.output.figures import quality, residuals, spectrum, torque
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection, Text
from ident.output.report.contents import ReportContents
from ident.output.report.detail import ZOOM, detail, points
from ident.output.tables import parameters, recordings
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


def fitted_parameters(contents: ReportContents) -> ReportSection:
    """Return values with intervals, several models side by side."""
    models = contents.models
    blocks: list[ReportBlock] = [parameters.side_by_side(models)]
    if any(figures.relative_half_width(entry) for model in models.values() for entry in model.all_parameters):
        caption = "Uncertainty of each parameter; beyond the dotted line not even its sign is known."
        blocks.append(Plot("precision", figures.precision(models), caption))
    for index, (name, model) in enumerate(models.items(), start=1):
        if model.assessment:
            sentences = Notes(tuple(summary_lines(model, model.assessment)))
            caption = "near -1 or 1, this motion determines only a combination of two parameters."
            plot = Plot(f"correlation-{index}", figures.correlation(model), f"Correlation of the errors: {caption}")
            blocks.append(Fold(f"Assessment of {name}", (sentences, plot), open=index == 1))
    return ReportSection("parameters", "Parameters", tuple(blocks))


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
    blocks: list[ReportBlock] = [recordings.side_by_side(contents.recordings, {"Role": roles})]
    for index, recording in enumerate(contents.recordings, start=1):
        caption = "The whole run. Click a joint in the legend to hide it."
        plot = Plot(f"motion-{index}", quality.motion(recording), caption)
        blocks.append(Fold(f"The motion in {recording.path.name}", (plot,), open=index == 1))
    return ReportSection("rig", "Rig and run", tuple(blocks))
