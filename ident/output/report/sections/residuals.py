"""Section with the residual by phase, window, quantity and frequency."""

from collections.abc import Iterator

from ident.output.figures import residuals, spectrum, torque
from ident.output.figures.theme import number, percent
from ident.output.report.blocks import Fold, Notes, Plot, ReportBlock, ReportSection, ReportTable
from ident.output.report.contents import ReportContents
from ident.residuals.analysis import ResidualAnalysis

MIN_SHARE = 0.1
"""Share of the mean square that a quantity must explain to be named."""
_QUANTITY = {"load": "computed load"}


def section(contents: ReportContents) -> ReportSection:
    """Return phases, worst windows, dependence on each quantity, and spectrum."""
    analyses = contents.primary_analyses
    several = len(analyses) > 1
    sentences = [
        f"{f'{name}: ' if several else ''}{line}"
        for name, analysis in analyses.items()
        for line in _sentences(analysis)
    ]
    blocks: list[ReportBlock] = [
        Notes(tuple(sentences)),
        Plot(
            "phases",
            residuals.phases(analyses),
            "Residual by phase of the motion; the percentages are the share of time in that phase.",
        ),
        Plot(
            "curves",
            residuals.curves(analyses),
            "Mean residual over each quantity. A correct model leaves a straight line at zero; each title gives the "
            "share of the mean square that the curve explains (with several models, for the first).",
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


def _sentences(analysis: ResidualAnalysis) -> Iterator[str]:
    """Yield the summary sentences and the quantity that explains most of each joint's residual."""
    yield from analysis.sentences
    strongest = [
        (joint.summary.number, max(joint.curves, key=lambda curve: curve.explained)) for joint in analysis.joints
    ]
    named = [
        f"joint {n} {_QUANTITY.get(curve.axis, curve.axis)} ({percent(curve.explained)})"
        for n, curve in strongest
        if curve.explained > MIN_SHARE
    ]
    if named and not analysis.within_noise:
        yield f"Quantity that explains most of the residual's mean square: {', '.join(named)}."


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
    head = ("joint", "recording", "time", "cycle", "phase", "RMS", "of the joint's own")
    table = ReportTable(head, rows, words=(0, 1, 4))
    plot = Plot(
        f"worst-{index}", torque.worst_windows(analysis), "The worst intervals of a quarter of a second, shaded."
    )
    label = f"Worst intervals{f', {name}' if name else ''}"
    return Fold(label, (plot, table), open=index == 1 and not analysis.within_noise)
