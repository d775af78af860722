"""Tables of a residual analysis."""

from collections.abc import Mapping

from ident.output.tables import ResultTable
from ident.residuals.analysis import ResidualAnalysis
from ident.residuals.phases import PHASES


def summary(analyses: Mapping[str, ResidualAnalysis]) -> ResultTable:
    """Return the residual of each joint beside its noise floor, by model if there are several."""
    several = len(analyses) > 1
    rows = []
    for name, analysis in analyses.items():
        for joint in analysis.joints:
            above = "" if analysis.test is None or joint.above_noise is None else f"{100 * joint.above_noise:.0f} %"
            if above and analysis.within_noise:
                above = "nothing"
            cells = (
                str(joint.summary.number),
                f"{joint.summary.rms:.3g} {joint.unit}",
                f"{100 * joint.summary.share:.1f} %",
                "unknown" if joint.noise_rms is None else f"{joint.noise_rms:.3g} {joint.unit}",
                above,
                f"{joint.summary.rms_all:.3g} {joint.unit}",
            )
            rows.append((name, *cells) if several else cells)
    head = ("joint", "RMS", "of RMS torque", "noise floor RMS", "of square above it", "RMS of all rows")
    return ResultTable(
        ("model", *head) if several else head,
        rows,
        "RMS where the joint moves. All rows: RMS with those near standstill, where dry friction is not determined. "
        "Noise floor: differences between repetitions, and quantization, which the model passes on to its torque.",
        words=(0,) if several else (),
        title="Residual",
    )


def phases(analysis: ResidualAnalysis) -> ResultTable:
    """Return the RMS residual of each joint in each phase of the motion."""
    rows = []
    for joint in analysis.joints:
        found = [joint.summary.phases.get(name) for name in PHASES]
        cells = [f"{phase.rms:.3g} ({100 * phase.error_share:.0f} %)" if phase else "" for phase in found]
        rows.append((f"{joint.summary.number} [{joint.unit}]", *cells))
    title = "RMS by phase of the motion (share of the joint's squared residual)"
    return ResultTable(("joint", *PHASES), rows, words=(), title=title)


def dependence(analysis: ResidualAnalysis) -> ResultTable:
    """Return the share of the squared residual that its mean over each quantity explains."""
    return ResultTable(
        ("joint", *(curve.axis for curve in analysis.joints[0].curves)),
        [
            (str(joint.summary.number), *(f"{100 * curve.explained:.0f} %" for curve in joint.curves))
            for joint in analysis.joints
        ],
        "Each quantity alone, the model as it is; the shares overlap. In the sentences above, the mechanism's "
        "parameters are refitted with the quantity. The pictures show the curves.",
        words=(),
        title="Share of squared residual explained by its mean over",
    )


def windows(analysis: ResidualAnalysis) -> ResultTable:
    """Return the worst intervals, with the names of the recordings if there are several."""
    several = len(analysis.predictions) > 1
    rows = [
        (
            str(window.joint),
            f"{window.start:.2f} s",
            f"{window.end:.2f} s",
            f"{window.rms:.3g} {analysis.joints[window.joint - 1].unit}",
            f"{window.times_overall:.1f} x",
            window.phase,
            str(window.cycle or ""),
            *([window.recording] if several else []),
        )
        for window in analysis.windows
    ]
    head = ("joint", "from", "to", "RMS", "of the joint's RMS", "phase of most error", "cycle")
    return ResultTable((*head, *(["in"] if several else [])), rows, words=(5, 7), title="Worst intervals")
