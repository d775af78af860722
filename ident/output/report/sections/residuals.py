"""Section with the residual by phase, window, quantity and frequency."""

from ident.output.figures import residuals, spectrum, torque
from ident.output.figures.theme import number
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection, ReportTable
from ident.output.report.contents import ReportContents
from ident.residuals.analysis import ResidualAnalysis


def section(contents: ReportContents) -> ReportSection:
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
            blocks.append(_worst_windows(index, name if several else "", analysis))
    within = all(analysis.within_noise for analysis in analyses.values())
    return ReportSection("where", "What is left: noise" if within else "Where the model fails", tuple(blocks))


def _worst_windows(index: int, name: str, analysis: ResidualAnalysis) -> Fold:
    rows = tuple(
        (
            f"joint {window.joint}",
            window.recording,
            f"{window.start:.2f} to {window.end:.2f} s",
            str(window.cycle or "–"),
            window.phase,
            f"{number(window.rms)} {analysis.joints[window.joint - 1].unit}",
            f"{window.times_overall:.1f} ×",
        )
        for window in analysis.windows
    )
    head = ("joint", "recording", "time", "cycle", "phase of most error", "RMS", "of the joint's RMS")
    table = ReportTable(head, rows, words=(0, 1, 4))
    plot = Plot(
        f"worst-{index}", torque.worst_windows(analysis), "The worst intervals of a quarter of a second, shaded."
    )
    label = f"Worst intervals{f', {name}' if name else ''}"
    return Fold(label, (plot, table), open=index == 1 and not analysis.within_noise)
