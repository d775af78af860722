"""Print a residual analysis."""

from rich.console import Console
from rich.table import Table

from ident.identification.model_file import ResidualTest
from ident.residuals.analysis import JointAnalysis, ResidualAnalysis
from ident.residuals.phases import PHASES


def show(analysis: ResidualAnalysis, console: Console) -> None:
    """Print a summary in sentences, the residual per joint and phase, its dependence, and the worst windows."""
    recordings = [prediction.prepared for prediction in analysis.predictions]
    names = ", ".join(prepared.recording.path.name for prepared in recordings)
    if any(prepared.recording.run.simulated for prepared in recordings):
        console.print("SIMULATED data.", style="bold yellow")
    if analysis.model and analysis.model.relative:
        console.print(
            "The torque gain is assumed: torques are RELATIVE, known up to one factor.", style="bold yellow"
        )
    console.print(f"Model against {names}, {recordings[0].bandwidth:g} Hz bandwidth", highlight=False)
    for sentence in analysis.sentences:
        console.print(sentence, highlight=False)
    console.print(_joint_table(analysis))
    console.print(_phase_table(analysis))
    console.print(_dependence_table(analysis))
    console.print(_window_table(analysis))


def _joint_table(analysis: ResidualAnalysis) -> Table:
    table = Table(title="Residual", title_justify="left")
    for heading in ("joint", "RMS", "of RMS torque", "noise floor RMS", "of square above it", "RMS of all rows"):
        table.add_column(heading, justify="right")
    for joint in analysis.joints:
        summary, noise = joint.summary, joint.noise_rms
        table.add_row(
            str(summary.number),
            f"{summary.rms:.3g} {joint.unit}",
            f"{100 * summary.share:.1f} %",
            "unknown" if noise is None else f"{noise:.3g} {joint.unit}",
            above_noise(analysis.test, joint),
            f"{summary.rms_all:.3g} {joint.unit}",
        )
    table.caption = (
        "RMS where the joint moves. All rows: RMS with those near standstill, where dry friction is not determined. "
        "Noise floor: differences between repetitions, and quantization."
    )
    return table


def above_noise(test: ResidualTest | None, joint: JointAnalysis) -> str:
    """The share of the mean square above the noise floor, in words if there is none."""
    if test is None or joint.above_noise is None:
        return ""
    return "nothing" if test.verdict == "within-noise" else f"{100 * joint.above_noise:.0f} %"


def _phase_table(analysis: ResidualAnalysis) -> Table:
    table = Table(title="RMS by phase of the motion (share of the joint's squared residual)", title_justify="left")
    table.add_column("joint", justify="right")
    for name in PHASES:
        table.add_column(name, justify="right")
    for joint in analysis.joints:
        phases = [joint.summary.phases.get(name) for name in PHASES]
        cells = [f"{phase.rms:.3g} ({100 * phase.error_share:.0f} %)" if phase else "" for phase in phases]
        table.add_row(f"{joint.summary.number} [{joint.unit}]", *cells)
    return table


def _dependence_table(analysis: ResidualAnalysis) -> Table:
    table = Table(title="Share of squared residual explained by its mean over", title_justify="left")
    table.add_column("joint", justify="right")
    axes = [curve.axis for curve in analysis.joints[0].curves]
    for axis in axes:
        table.add_column(axis, justify="right")
    for joint in analysis.joints:
        table.add_row(str(joint.summary.number), *_shares(joint))
    table.caption = (
        "Each quantity alone, the model as it is; the shares overlap. In the sentences above, the mechanism's "
        "parameters are refitted with the quantity. The pictures show the curves."
    )
    return table


def _shares(joint: JointAnalysis) -> list[str]:
    return [f"{100 * curve.explained:.0f} %" for curve in joint.curves]


def _window_table(analysis: ResidualAnalysis) -> Table:
    table = Table(title="Worst intervals", title_justify="left")
    several = len(analysis.predictions) > 1
    headings = ("joint", "from", "to", "RMS", "of the joint's RMS", "phase of most error", "cycle")
    for heading in (*headings, *(["in"] if several else [])):
        table.add_column(heading, justify="left" if heading in ("in", "phase of most error") else "right")
    for window in analysis.windows:
        table.add_row(
            str(window.joint),
            f"{window.start:.2f} s",
            f"{window.end:.2f} s",
            f"{window.rms:.3g} {analysis.joints[window.joint - 1].unit}",
            f"{window.times_overall:.1f} x",
            window.phase,
            str(window.cycle or ""),
            *([window.recording] if several else []),
        )
    return table
