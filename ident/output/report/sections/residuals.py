"""Where the model fails."""

from collections.abc import Iterator

from ident.output.figures import residuals, spectrum, torque
from ident.output.figures.theme import number, percent
from ident.output.report.blocks import ReportBlock, Fold, Notes, Plot, ReportSection, ReportTable
from ident.output.report.contents import ReportContents
from ident.residuals.analysis import Comparison

LEAST = 0.1
"""Share of the mean square below which a quantity is not named."""
_QUANTITY = {"load": "computed load"}


def section(material: ReportContents) -> ReportSection:
    """Phases, worst stretches, what the residual depends on, spectrum."""
    judged = material.primary_comparisons
    several = len(judged) > 1
    said = [f"{f'{name}: ' if several else ''}{line}" for name, one in judged.items() for line in _said(one)]
    blocks: list[ReportBlock] = [
        Notes(tuple(said)),
        Plot(
            "phases",
            residuals.phases(judged),
            "Residual by phase of the motion; the percentages say how much of the time the joint is in that phase.",
        ),
        Plot(
            "curves",
            residuals.curves(judged),
            "Mean residual over what it may depend on. A straight line at zero is what a right model leaves; each "
            "title says how much of the mean square the curve accounts for, of several models that of the first.",
        ),
        Plot("spectrum", spectrum.densities(judged), "By frequency: what is measured, what is left, what is noise."),
    ]
    for place, (name, comparison) in enumerate(judged.items(), start=1):
        if comparison.windows:
            blocks.append(_worst(place, name if several else "", comparison))
    return ReportSection("where", "Where the model fails", tuple(blocks))


def _said(comparison: Comparison) -> Iterator[str]:
    """What stands out, and with what quantity the residual goes most."""
    yield from comparison.sentences
    most = [
        (joint.summary.number, max(joint.curves, key=lambda curve: curve.explained)) for joint in comparison.joints
    ]
    named = [
        f"joint {n} {_QUANTITY.get(curve.axis, curve.axis)} ({percent(curve.explained)})"
        for n, curve in most
        if curve.explained > LEAST
    ]
    if named:
        yield f"Most of the residual's mean square goes with: {', '.join(named)}."


def _worst(place: int, name: str, comparison: Comparison) -> Fold:
    rows = tuple(
        (
            f"joint {window.joint}",
            window.recording,
            f"{window.start:.2f} to {window.end:.2f} s",
            str(window.cycle or "–"),
            window.phase,
            f"{number(window.rms)} {comparison.joints[window.joint - 1].unit}",
            f"{window.times_overall:.1f} ×",
        )
        for window in comparison.windows
    )
    head = ("joint", "recording", "time", "cycle", "phase", "RMS", "of the joint's own")
    table = ReportTable(head, rows, words=(0, 1, 4))
    plot = Plot(f"worst-{place}", torque.worst_windows(comparison), "The worst stretches of a quarter of a second, shaded.")
    return Fold(f"Worst stretches{f', {name}' if name else ''}", (plot, table), open=place == 1)
