"""A diagnosis as pictures: the ladder, every finding over the quantity in which it shows, what is unknown."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ident.data.dataset import Dataset
from ident.diagnosis import binned_residual
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document import Document
from ident.diagnosis.nonparametric_fit import NonparametricFit
from ident.diagnosis.steps import Finding
from ident.dynamics.effects.learned_curve import Curve
from ident.identification.prediction import Prediction
from ident.output.plots.fit import COMPUTED, MEASURED, NOMINAL, figure
from ident.output.plots.residuals import NOISE, curves, spectra
from ident.residuals.analysis import compare
from ident.residuals.curves import means
from recordings.recording import Floats

OPTIONAL_PICTURES = ("finding_*.png", "remains*.png")
"""Patterns of the pictures that are not drawn each time."""
_BOTH_WAYS = ("position", "load")
"""Axes over which each direction of motion has a mean of its own."""
_SLOW = 0.1
"""Share of the highest speed below which nothing is divided by the speed."""


def draw(found: Diagnosis, document: Document, folder: Path) -> None:
    """Draw into `folder`."""
    about = ", ".join(document.recordings)
    ladder(folder / "ladder.png", f"{document.verdict}: {about}", document)
    for number, one in enumerate(found.selection.findings, start=1):
        finding(folder / f"finding_{number}_{one.term.name}.png", found, one)
    if found.unexplained.significant:
        unexplained_residual(folder, about, found)
    if found.learned:
        learned_curves(folder / "remains_curves.png", about, found, found.learned)


def ladder(path: Path, title: str, document: Document) -> None:
    """Training and held-out error of each rung, joint by joint, and the noise floor as the line to reach."""
    dof = len(document.joints)
    names = document.labels
    with figure(path, title, 2.0 + 3.2 * dof, 1.6 + 0.5 * len(names)) as drawn:
        axes = drawn.subplots(1, dof, squeeze=False, sharex=True, sharey=True)[0]
        place = np.arange(len(names))
        for joint, axis in enumerate(axes):
            seen = [rung.train_rms[joint] for rung in document.rungs]
            held = [rung.validate_rms[joint] for rung in document.rungs]
            axis.barh(place - 0.2, seen, 0.36, color=NOMINAL, label="training", zorder=2)
            axis.barh(place + 0.2, held, 0.36, color=COMPUTED, label="held out", zorder=2)
            axis.axvline(document.noise_rms[joint], color=NOISE, lw=1.8, ls="--", zorder=3, label="noise floor")
            axis.set(yticks=place, yticklabels=names, title=f"joint {joint + 1}")
            axis.set_xlabel(f"RMS error [{document.effort_units[joint]}]")
        axes[0].invert_yaxis()
        axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1.1), ncols=3, frameon=False, fontsize=9)


def finding(path: Path, found: Diagnosis, one: Finding) -> None:
    """The residual over the effect's own axis, without the effect and with it, in each direction of motion if that
    might hide it: friction has another sign in each."""
    datasets = found.split.datasets
    joints = one.term.joints
    axis_name = one.term.effect.axis
    with figure(path, f"{one.term.name}: residual without it and with it", 2.0 + 3.6 * len(joints), 3.8) as drawn:
        axes = drawn.subplots(1, len(joints), squeeze=False, sharey=True)[0]
        for axis, joint in zip(axes, joints, strict=True):
            unit = datasets[0].recording.rig.effort_units[joint]
            x, label = binned_residual.axis_values(axis_name, datasets, found.selection.computed, joint)
            ahead = np.concatenate([data.motion.velocity[:, joint] for data in datasets]) > 0
            for residuals, colour, name in ((one.residuals_without, NOMINAL, "without"), (one.residuals_with, COMPUTED, "with")):
                left = np.concatenate([part[:, joint] for part in residuals])
                if axis_name in _BOTH_WAYS:
                    _curve(axis, np.where(ahead, x, np.nan), left, colour, f"{name}, forwards")
                    _curve(axis, np.where(ahead, np.nan, x), left, colour, f"{name}, backwards", "--")
                else:
                    _curve(axis, x, left, colour, name)
            floor = found.selection.noise_floor.rms[joint]
            axis.axhspan(-floor, floor, color=NOISE, alpha=0.2, lw=0, label="± noise floor")
            axis.axhline(0, color=MEASURED, lw=0.8)
            axis.set(title=f"joint {joint + 1}", xlabel=label)
        axes[0].set_ylabel(f"residual [{unit}]")
        axes[0].legend(frameon=False, fontsize=9)


def unexplained_residual(folder: Path, about: str, found: Diagnosis) -> None:
    """What the last model leaves, over each quantity that it may depend on, and its spectrum where that tells."""
    pairs = zip(found.split.datasets, found.selection.computed, strict=True)
    left = compare(None, [Prediction(data, computed) for data, computed in pairs])
    title = f"What no effect explains: mean, its 95 % band, ± RMS (dotted) and floor (green): {about}"
    curves(folder / "remains.png", title, left, found.selection.noise_floor.rms.tolist())
    if "frequency" in found.unexplained.variables:
        spectra(folder / "remains_spectrum.png", f"What no effect explains, by frequency: {about}", left)


def learned_curves(path: Path, about: str, found: Diagnosis, stand_in: NonparametricFit) -> None:
    """The curves that were learned, over what the remainder was found to depend on: a row per joint."""
    joints = sorted({curve.joint for curve in stand_in.curves})
    rows = [[curve for curve in stand_in.curves if curve.joint == joint] for joint in joints]
    columns = max(map(len, rows))
    title = f"What no effect explains, over what it depends on: {about}"
    with figure(path, title, 2.5 + 4.5 * columns, 1.2 + 2.8 * len(rows)) as drawn:
        for row, own in zip(drawn.subplots(len(rows), columns, squeeze=False), rows, strict=True):
            for axis, curve in zip(row, own, strict=False):
                _learned(axis, found, stand_in, curve)
            for axis in row[len(own) :]:
                axis.set_axis_off()
        drawn.axes[0].legend(frameon=False, fontsize=9)


def _learned(axis: Any, found: Diagnosis, stand_in: NonparametricFit, curve: Curve) -> None:
    """The residual by what the curve is multiplied with, less the joint's other curves: without and with it."""
    datasets, joint = found.split.datasets, curve.joint - 1
    predictions = [Prediction(data, one) for data, one in zip(datasets, found.selection.computed, strict=True)]
    x, label = _signal(found, curve)
    factor = _factor(datasets, curve)
    divisor = np.where(np.abs(factor) > _SLOW * np.nanmax(np.abs(factor)), factor, np.nan)
    others = [one for one in stand_in.curves if one.joint == curve.joint and one is not curve]
    taken = sum(np.interp(_signal(found, one)[0], one.knots, one.values) * _factor(datasets, one) for one in others)
    before, after = (
        np.concatenate([part[:, joint] for part in state.residuals])
        for state in (found.selection.steps[-1].model, stand_in.model)
    )
    for left, colour, name in ((before - taken, NOMINAL, "without curves"), (after, COMPUTED, "with curves")):
        centre, mean, _, half_width, _, _ = means("velocity", x, left / divisor, predictions)
        axis.fill_between(centre, mean - half_width, mean + half_width, color=colour, alpha=0.3, lw=0)
        axis.plot(centre, mean, color=colour, lw=1.6, marker="o", ms=2.5, label=f"{name}, 95 % band")
    axis.plot(curve.knots, curve.values, color=MEASURED, lw=1.2, ls="--", label="learned")
    axis.axhline(0, color=MEASURED, lw=0.8)
    if curve.times != "velocity":
        floor = found.selection.noise_floor.rms[joint]
        axis.axhspan(-floor, floor, color=NOISE, alpha=0.15, lw=0, label="± noise floor")
    rig = datasets[0].recording.rig
    unit = rig.effort_units[joint] + (f" s/{rig.position_units[joint]}" if curve.times == "velocity" else "")
    over = {"one": "residual", "direction": "residual × direction", "velocity": "residual / velocity"}[curve.times]
    axis.set(xlabel=label if curve.variable == "time" else f"{label} of joint {curve.of_joint}")
    axis.set(ylabel=f"joint {curve.joint}: {over} [{unit}]")


def _signal(found: Diagnosis, curve: Curve) -> tuple[Floats, str]:
    """What the curve is over, in all rows (m,), and its name with its unit."""
    return binned_residual.axis_values(curve.variable, found.split.datasets, found.selection.computed, curve.of_joint - 1)


def _factor(datasets: Sequence[Dataset], curve: Curve) -> Floats:
    """(m,) what the curve is multiplied with, in all rows."""
    velocity: Floats = np.concatenate([data.motion.velocity[:, curve.joint - 1] for data in datasets])
    if curve.times == "velocity":
        return velocity
    return np.ones_like(velocity) if curve.times == "one" else np.sign(velocity)


def _curve(axis: Any, x: Floats, y: Floats, colour: str, name: str, line: str = "-") -> None:
    """Samples, thinned out, and their mean in bins."""
    if not (np.isfinite(x) & np.isfinite(y)).any():
        return
    drawn = binned_residual.bin_means(x, y)
    axis.plot(drawn.x, drawn.y, ".", ms=1.2, color=colour, alpha=0.25, zorder=1)
    axis.plot(drawn.centre, drawn.mean, color=colour, lw=1.8, ls=line, label=name, zorder=3)
