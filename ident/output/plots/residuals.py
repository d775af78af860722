"""Draw a residual analysis: phases, curves, spectrum, the worst windows, and the residual over time."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ident.identification.prediction import Prediction
from ident.output.plots import fit
from ident.output.plots.fit import COMPUTED, MEASURED, NOMINAL, figure
from ident.residuals.analysis import ResidualAnalysis
from ident.residuals.curves import BinnedCurve
from ident.residuals.phases import PHASES
from ident.residuals.windows import Window

NOISE = "#009E73"
"""From the palette of Okabe and Ito, as the others."""
AXIS_RANGE = 1.3
"""Range of the residual axis over the largest RMS of any bin."""
WINDOW_MARGIN = 0.5
"""Time that is drawn before and after a worst window [s]."""


def draw(analysis: ResidualAnalysis, folder: Path) -> None:
    """Draw all pictures into `folder`."""
    first = analysis.predictions[0].prepared
    names = ", ".join(prediction.prepared.recording.path.name for prediction in analysis.predictions)
    recordings = f"{names}, {first.bandwidth:g} Hz bandwidth{', SIMULATED' if first.recording.run.simulated else ''}"
    phases(
        folder / "phases.png",
        f"Residual by phase of the motion (with its share of the time): {recordings}",
        analysis,
    )
    curves(
        folder / "curves.png",
        f"Mean residual, its 95 % band, ± RMS (dotted) and noise (green): {recordings}",
        analysis,
    )
    spectra(folder / "spectrum.png", f"Residual by frequency: {recordings}", analysis)
    worst_windows(folder / "worst.png", f"The worst stretches: {recordings}", analysis)
    for number, prediction in enumerate(analysis.predictions, start=1):
        fit.residual(
            folder / f"residual_{number}.png", f"Residual: {recordings}", prediction.prepared, prediction.computed
        )


def phases(path: Path, title: str, analysis: ResidualAnalysis) -> None:
    """Draw the RMS of each joint in each phase, with its noise floor."""
    with figure(path, title, 10.0, 4.0) as canvas:
        axes = canvas.subplots(1, len(analysis.joints), squeeze=False)[0]
        for axis, joint in zip(axes, analysis.joints, strict=True):
            phases_of_joint = joint.summary.phases
            names = [name for name in PHASES if name in phases_of_joint]
            axis.bar(names, [phases_of_joint[name].rms for name in names], color=COMPUTED, width=0.6, zorder=2)
            for name in names:
                share = f"{100 * phases_of_joint[name].time_share:.0f} %"
                axis.annotate(share, (name, phases_of_joint[name].rms), ha="center", va="bottom", fontsize=8)
            if joint.split:
                axis.axhline(joint.split.noise_rms, color=NOISE, lw=1.6, ls="--", zorder=3, label="noise")
                axis.legend(frameon=False, loc="upper left", fontsize=8)
            axis.margins(y=0.25)
            axis.tick_params(axis="x", labelsize=8, rotation=20)
            axis.set_title(f"joint {joint.summary.number}", fontsize=10)
            axis.set_ylabel(f"RMS residual [{joint.unit}]")


def curves(path: Path, title: str, analysis: ResidualAnalysis, floors: Sequence[float] | None = None) -> None:
    """Draw the mean residual, one row per joint, one column per quantity.

    floors: (dof,) noise floors to draw; None: the noise estimated from the repetitions, if there are any.
    """
    noise = [joint.split.noise_rms if joint.split else None for joint in analysis.joints]
    columns = max(len(joint.curves) for joint in analysis.joints)
    rows = len(analysis.joints)
    with figure(path, title, 3.2 * columns, 1.0 + 2.4 * rows) as canvas:
        grid = canvas.subplots(rows, columns, squeeze=False, sharey="row")
        for row, joint, floor in zip(grid, analysis.joints, floors or noise, strict=True):
            for axis, curve in zip(row, joint.curves, strict=True):
                _curve(axis, curve, floor)
            row[0].set_ylabel(f"joint {joint.summary.number}\nresidual [{joint.unit}]")
            # The wide bands of bins with few samples must not set the scale.
            limit = AXIS_RANGE * max(
                (float(curve.rms.max()) for curve in joint.curves if len(curve.rms)), default=1.0
            )
            row[0].set_ylim(-limit or -1.0, limit or 1.0)


def _curve(axis: Any, curve: BinnedCurve, floor: float | None) -> None:
    low, high = curve.mean - curve.half_width, curve.mean + curve.half_width
    axis.axhline(0, color=MEASURED, lw=0.8)
    if floor is not None:
        axis.axhspan(-floor, floor, color=NOISE, alpha=0.15, lw=0)
    axis.plot(curve.centre, curve.rms, color=NOMINAL, lw=1, ls=":")
    axis.plot(curve.centre, -curve.rms, color=NOMINAL, lw=1, ls=":")
    axis.fill_between(curve.centre, low, high, color=COMPUTED, alpha=0.3, lw=0)
    axis.plot(curve.centre, curve.mean, color=COMPUTED, lw=1.4, marker="o", ms=2.5)
    unit = f" [{curve.unit}]" if curve.unit else ""
    axis.set_xlabel(f"{'computed load' if curve.axis == 'load' else curve.axis}{unit}")
    axis.set_title(f"accounts for {100 * curve.explained:.0f} %", fontsize=9)
    if curve.axis == "cycle":
        axis.xaxis.get_major_locator().set_params(integer=True)


def spectra(path: Path, title: str, analysis: ResidualAnalysis) -> None:
    """Draw the amplitude densities of torque, residual and noise."""
    rows = len(analysis.joints)
    with figure(path, title, 10.0, 1.2 + 2.4 * rows) as canvas:
        axes = canvas.subplots(rows, 1, sharex=True, squeeze=False)[:, 0]
        for axis, joint in zip(axes, analysis.joints, strict=True):
            spectrum = joint.spectrum
            axis.semilogy(
                spectrum.frequency, np.sqrt(spectrum.torque), color=MEASURED, lw=2.5, alpha=0.35, label="torque"
            )
            axis.semilogy(spectrum.frequency, np.sqrt(spectrum.residual), color=COMPUTED, lw=1.3, label="residual")
            if spectrum.noise is not None:
                axis.semilogy(
                    spectrum.frequency, np.sqrt(spectrum.noise), color=NOISE, lw=1.3, ls="--", label="noise"
                )
            axis.set_ylabel(f"joint {joint.summary.number}\n[{joint.unit}/√Hz]")
            axis.margins(x=0)
        axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)
        axes[-1].set_xlabel("frequency [Hz]")


def worst_windows(path: Path, title: str, analysis: ResidualAnalysis) -> None:
    """Draw measured and computed torque around each of the worst windows."""
    if not analysis.windows:
        return
    by_name = {prediction.prepared.recording.path.name: prediction for prediction in analysis.predictions}
    rows = -(-len(analysis.windows) // 2)
    with figure(path, title, 11.0, 1.0 + 2.4 * rows) as canvas:
        axes = canvas.subplots(rows, 2, squeeze=False).ravel()
        for axis, window in zip(axes, analysis.windows, strict=False):
            _window(axis, window, by_name[window.recording])
        for axis in axes[len(analysis.windows) :]:
            axis.set_axis_off()
        axes[0].legend(frameon=False, fontsize=8)


def _window(axis: Any, window: Window, prediction: Prediction) -> None:
    prepared, joint = prediction.prepared, window.joint - 1
    rows = (prepared.time >= window.start - WINDOW_MARGIN) & (prepared.time <= window.end + WINDOW_MARGIN)
    time = prepared.time[rows]
    axis.axvspan(window.start, window.end, color=NOMINAL, alpha=0.3, lw=0)
    axis.plot(time, prepared.torque[rows, joint], color=MEASURED, lw=3, alpha=0.35, label="measured")
    axis.plot(time, prediction.computed[rows, joint], color=COMPUTED, lw=1.3, label="model")
    axis.margins(x=0)
    axis.set_xlabel("time [s]")
    axis.set_ylabel(f"joint {window.joint} [{prepared.recording.rig.effort_units[joint]}]")
    cycle = f", cycle {window.cycle}" if window.cycle else ""
    axis.set_title(f"{window.recording}: {window.phase}{cycle}, {window.times_overall:.1f} times overall", fontsize=9)
