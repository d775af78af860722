"""Draw a diagnosis: steps of the selection, residual with and without each finding, unexplained residual."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis import binned_residual
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import Document
from ident.diagnosis.nonparametric_fit import NonparametricFit
from ident.diagnosis.steps import Finding
from ident.dynamics.effects.learned_curve import LearnedCurve
from ident.identification.prediction import Prediction
from ident.output.plots.fit import COMPUTED, MEASURED, NOMINAL, figure
from ident.output.plots.residuals import NOISE, curves, spectra
from ident.residuals.analysis import analyse
from ident.residuals.curves import binned_means
from recordings.recording import Floats

OPTIONAL_PICTURES = ("finding_*.png", "remains*.png")
"""Name patterns of the pictures that only some diagnoses have."""
_SEPARATE_DIRECTIONS = ("position", "load")
"""Axes on which the two directions of motion are averaged separately."""
_MIN_SPEED_SHARE = 0.1
"""Share of the highest speed below which the residual is not divided by the speed."""


def draw(diagnosis: Diagnosis, document: Document, folder: Path) -> None:
    """Draw all pictures into `folder`."""
    recordings = ", ".join(document.recordings)
    step_errors(folder / "ladder.png", f"{document.verdict}: {recordings}", document)
    for number, finding in enumerate(diagnosis.selection.findings, start=1):
        finding_residual(folder / f"finding_{number}_{finding.term.name}.png", diagnosis, finding)
    if diagnosis.unexplained.significant:
        unexplained_residual(folder, recordings, diagnosis)
    if diagnosis.learned:
        learned_curves(folder / "remains_curves.png", recordings, diagnosis, diagnosis.learned)


def step_errors(path: Path, title: str, document: Document) -> None:
    """Draw training and held-out RMS error of each step per joint, with the noise floor as a line."""
    dof = len(document.joints)
    names = document.labels
    with figure(path, title, 2.0 + 3.2 * dof, 1.6 + 0.5 * len(names)) as canvas:
        axes = canvas.subplots(1, dof, squeeze=False, sharex=True, sharey=True)[0]
        positions = np.arange(len(names))
        for joint, axis in enumerate(axes):
            train = [step.train_rms[joint] for step in document.rungs]
            test = [step.validate_rms[joint] for step in document.rungs]
            axis.barh(positions - 0.2, train, 0.36, color=NOMINAL, label="training", zorder=2)
            axis.barh(positions + 0.2, test, 0.36, color=COMPUTED, label="held out", zorder=2)
            axis.axvline(document.noise_rms[joint], color=NOISE, lw=1.8, ls="--", zorder=3, label="noise floor")
            axis.set(yticks=positions, yticklabels=names, title=f"joint {joint + 1}")
            axis.set_xlabel(f"RMS error [{document.effort_units[joint]}]")
        axes[0].invert_yaxis()
        axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1.1), ncols=3, frameon=False, fontsize=9)


def finding_residual(path: Path, diagnosis: Diagnosis, finding: Finding) -> None:
    """Draw the residual over the effect's axis, without the effect and with it.

    Over position and load the directions of motion are separate, as friction changes its sign with them.
    """
    recordings = diagnosis.split.recordings
    joints = finding.term.joints
    axis_name = finding.term.effect.axis
    with figure(
        path, f"{finding.term.name}: residual without it and with it", 2.0 + 3.6 * len(joints), 3.8
    ) as canvas:
        axes = canvas.subplots(1, len(joints), squeeze=False, sharey=True)[0]
        for axis, joint in zip(axes, joints, strict=True):
            unit = recordings[0].recording.rig.effort_units[joint]
            x, label = binned_residual.axis_values(axis_name, recordings, diagnosis.model.computed, joint)
            forwards = np.concatenate([data.motion.velocity[:, joint] for data in recordings]) > 0
            for residuals, colour, name in (
                (finding.residuals_without, NOMINAL, "without"),
                (finding.residuals_with, COMPUTED, "with"),
            ):
                residual = np.concatenate([array[:, joint] for array in residuals])
                if axis_name in _SEPARATE_DIRECTIONS:
                    _draw_bin_means(axis, np.where(forwards, x, np.nan), residual, colour, f"{name}, forwards")
                    _draw_bin_means(axis, np.where(forwards, np.nan, x), residual, colour, f"{name}, backwards", "--")
                else:
                    _draw_bin_means(axis, x, residual, colour, name)
            floor = diagnosis.model.noise_floor.rms[joint]
            axis.axhspan(-floor, floor, color=NOISE, alpha=0.2, lw=0, label="± noise floor")
            axis.axhline(0, color=MEASURED, lw=0.8)
            axis.set(title=f"joint {joint + 1}", xlabel=label)
        axes[0].set_ylabel(f"residual [{unit}]")
        axes[0].legend(frameon=False, fontsize=9)


def unexplained_residual(folder: Path, recordings: str, diagnosis: Diagnosis) -> None:
    """Draw the residual of the last model over each quantity, and its spectrum if it depends on frequency."""
    pairs = zip(diagnosis.split.recordings, diagnosis.model.computed, strict=True)
    analysis = analyse(None, [Prediction(data, computed) for data, computed in pairs])
    title = f"What no effect explains: mean, its 95 % band, ± RMS (dotted) and floor (green): {recordings}"
    curves(folder / "remains.png", title, analysis, diagnosis.model.noise_floor.rms.tolist())
    if "frequency" in diagnosis.unexplained.variables:
        spectra(folder / "remains_spectrum.png", f"What no effect explains, by frequency: {recordings}", analysis)


def learned_curves(path: Path, recordings: str, diagnosis: Diagnosis, fit: NonparametricFit) -> None:
    """Draw the learned curves over the variables on which the unexplained residual depends, one row per joint."""
    joints = sorted({curve.joint for curve in fit.curves})
    rows = [[curve for curve in fit.curves if curve.joint == joint] for joint in joints]
    columns = max(map(len, rows))
    title = f"What no effect explains, over what it depends on: {recordings}"
    with figure(path, title, 2.5 + 4.5 * columns, 1.2 + 2.8 * len(rows)) as canvas:
        for row, joint_curves in zip(canvas.subplots(len(rows), columns, squeeze=False), rows, strict=True):
            for axis, curve in zip(row, joint_curves, strict=False):
                _draw_learned_curve(axis, diagnosis, fit, curve)
            for axis in row[len(joint_curves) :]:
                axis.set_axis_off()
        canvas.axes[0].legend(frameon=False, fontsize=9)


def _draw_learned_curve(axis: Any, diagnosis: Diagnosis, fit: NonparametricFit, curve: LearnedCurve) -> None:
    """Draw a curve and the residual it explains, divided by the curve's factor, without the joint's other curves."""
    recordings, joint = diagnosis.split.recordings, curve.joint - 1
    predictions = [
        Prediction(data, computed) for data, computed in zip(recordings, diagnosis.model.computed, strict=True)
    ]
    x, label = _curve_variable(diagnosis, curve)
    factor = _curve_factor(recordings, curve)
    divisor = np.where(np.abs(factor) > _MIN_SPEED_SHARE * np.nanmax(np.abs(factor)), factor, np.nan)
    siblings = [sibling for sibling in fit.curves if sibling.joint == curve.joint and sibling is not curve]
    sibling_torque = sum(
        np.interp(_curve_variable(diagnosis, sibling)[0], sibling.knots, sibling.values)
        * _curve_factor(recordings, sibling)
        for sibling in siblings
    )
    before, after = (
        np.concatenate([array[:, joint] for array in model.residuals]) for model in (diagnosis.model, fit.model)
    )
    for residual, colour, name in (
        (before - sibling_torque, NOMINAL, "without curves"),
        (after, COMPUTED, "with curves"),
    ):
        centre, mean, _, half_width, _, _ = binned_means("velocity", x, residual / divisor, predictions)
        axis.fill_between(centre, mean - half_width, mean + half_width, color=colour, alpha=0.3, lw=0)
        axis.plot(centre, mean, color=colour, lw=1.6, marker="o", ms=2.5, label=f"{name}, 95 % band")
    axis.plot(curve.knots, curve.values, color=MEASURED, lw=1.2, ls="--", label="learned")
    axis.axhline(0, color=MEASURED, lw=0.8)
    if curve.multiplier != "velocity":
        floor = diagnosis.model.noise_floor.rms[joint]
        axis.axhspan(-floor, floor, color=NOISE, alpha=0.15, lw=0, label="± noise floor")
    rig = recordings[0].recording.rig
    unit = rig.effort_units[joint] + (f" s/{rig.position_units[joint]}" if curve.multiplier == "velocity" else "")
    quantity = {"one": "residual", "direction": "residual × direction", "velocity": "residual / velocity"}[
        curve.multiplier
    ]
    axis.set(xlabel=label if curve.variable == "time" else f"{label} of joint {curve.variable_joint}")
    axis.set(ylabel=f"joint {curve.joint}: {quantity} [{unit}]")


def _curve_variable(diagnosis: Diagnosis, curve: LearnedCurve) -> tuple[Floats, str]:
    """Return the curve's variable in all rows (m,), and its name with its unit."""
    return binned_residual.axis_values(
        curve.variable, diagnosis.split.recordings, diagnosis.model.computed, curve.variable_joint - 1
    )


def _curve_factor(recordings: Sequence[PreparedRecording], curve: LearnedCurve) -> Floats:
    """Return the factor of the curve in all rows (m,)."""
    velocity: Floats = np.concatenate([data.motion.velocity[:, curve.joint - 1] for data in recordings])
    if curve.multiplier == "velocity":
        return velocity
    return np.ones_like(velocity) if curve.multiplier == "one" else np.sign(velocity)


def _draw_bin_means(axis: Any, x: Floats, y: Floats, colour: str, name: str, line: str = "-") -> None:
    """Draw decimated samples and their mean in bins."""
    if not (np.isfinite(x) & np.isfinite(y)).any():
        return
    bins = binned_residual.bin_means(x, y)
    axis.plot(bins.x, bins.y, ".", ms=1.2, color=colour, alpha=0.25, zorder=1)
    axis.plot(bins.centre, bins.mean, color=colour, lw=1.8, ls=line, label=name, zorder=3)
