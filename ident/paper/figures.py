"""Draw Figures 3 and 6 to 10 of the paper with the given recordings."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from ident.data.prepared_recording import PreparedRecording
from ident.output.plots.fit import COMPUTED, MEASURED, NOMINAL, figure
from ident.paper.methods import MANUFACTURER, MethodComparison
from recordings.recording import Floats

COLOURS: Mapping[str, str] = {
    "pso": COMPUTED,
    "rls": "#D55E00",
    "dls": "#009E73",
    "svd": "#CC79A7",
    MANUFACTURER: NOMINAL,
}
"""Palette of Okabe and Ito."""

_IDENTIFICATION, _VALIDATION = 0, 1


def draw(comparison: MethodComparison, folder: Path) -> None:
    """Draw all figures into `folder`, named by their numbers in the paper."""
    identification = comparison.prepared[_IDENTIFICATION]
    curves = {name: result.torque[_IDENTIFICATION] for name, result in comparison.results.items()}
    assert identification.nominal is not None
    manufacturer, pso = {MANUFACTURER: identification.nominal}, {"pso": curves["pso"]}
    _draw(
        folder / "figure_3.png",
        "Figure 3: (a) manufacturer's model, (b) model identified by PSO",
        identification,
        [manufacturer, pso],
    )
    _draw(folder / "figure_6.png", "Figure 6: measured, and identified by PSO", identification, [pso])
    for number, method in ((7, "rls"), (8, "dls"), (9, "svd")):
        title = f"Figure {number}: measured, identified by {method.upper()}, identified by PSO"
        _draw(folder / f"figure_{number}.png", title, identification, [{method: curves[method], **pso}])
    validation_curves = {name: comparison.results[name].torque[_VALIDATION] for name in ("rls", "dls", "svd", "pso")}
    title = "Figure 10: validation on another motion"
    _draw(folder / "figure_10.png", title, comparison.prepared[_VALIDATION], [validation_curves])


def _draw(path: Path, title: str, prepared: PreparedRecording, columns: Sequence[Mapping[str, Floats]]) -> None:
    """Draw one row for each joint and one column for each set of computed torques."""
    recording = prepared.recording
    title += f"\n{recording.path.name}{', SIMULATED' if recording.run.simulated else ''}"
    rows = prepared.first_cycle
    time, dof = prepared.time[rows], prepared.torque.shape[1]
    with figure(path, title, 10.0, 1.8 + 2.2 * dof) as canvas:
        axes = canvas.subplots(dof, len(columns), sharex=True, sharey="row", squeeze=False)
        for column, curves in enumerate(columns):
            for joint in range(dof):
                axis = axes[joint, column]
                axis.plot(time, prepared.torque[rows, joint], color=MEASURED, lw=3, alpha=0.35, label="measured")
                for name, torque in curves.items():
                    axis.plot(time, torque[rows, joint], color=COLOURS[name], lw=1.1, label=name)
                axis.margins(x=0)
            axes[-1, column].set_xlabel("time [s]")
            axes[0, column].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=5, frameon=False)
        for joint in range(dof):
            axes[joint, 0].set_ylabel(f"joint {joint + 1}\ntorque [N m]")
