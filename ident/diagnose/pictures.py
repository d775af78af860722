"""A diagnosis as pictures: the ladder, every finding over the quantity in which it shows, what is unknown."""

from pathlib import Path
from typing import Any

import numpy as np

from ident.compare.comparison import compare
from ident.compare.pictures import NOISE, curves, spectra
from ident.diagnose import signature
from ident.diagnose.diagnosis import Diagnosis
from ident.diagnose.document import Document
from ident.diagnose.rungs import Finding
from ident.plots import COMPUTED, MEASURED, NOMINAL, figure
from ident.prediction import Prediction
from recordings.recording import Floats


def draw(found: Diagnosis, document: Document, folder: Path) -> None:
    """Draw into `folder`."""
    about = ", ".join(document.recordings)
    ladder(folder / "ladder.png", f"{document.verdict}: {about}", document)
    for number, one in enumerate(found.ladder.findings, start=1):
        finding(folder / f"finding_{number}_{one.term.name}.png", found, one)
    if found.remainder.unexplained:
        remains(folder, about, found)


def ladder(path: Path, title: str, document: Document) -> None:
    """Training and held-out error of each rung, joint by joint, and the noise floor as the line to reach."""
    dof = len(document.joints)
    names = document.labels
    with figure(path, title, 2.0 + 3.2 * dof, 1.6 + 0.5 * len(names)) as drawn:
        axes = drawn.subplots(1, dof, squeeze=False, sharey=True)[0]
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
    """The residual over the effect's own axis, without the effect and with it."""
    datasets = found.material.datasets
    joints = one.term.joints
    axis_name = one.term.effect.axis
    with figure(path, f"{one.term.name}: residual without it and with it", 2.0 + 3.6 * len(joints), 3.8) as drawn:
        axes = drawn.subplots(1, len(joints), squeeze=False, sharey=True)[0]
        for axis, joint in zip(axes, joints, strict=True):
            unit = datasets[0].recording.rig.effort_units[joint]
            x, label = signature.over(axis_name, datasets, found.ladder.computed, joint)
            for residuals, colour, name in ((one.without, NOMINAL, "without"), (one.with_it, COMPUTED, "with")):
                _curve(axis, x, np.concatenate([part[:, joint] for part in residuals]), colour, name)
            floor = found.ladder.floor.rms[joint]
            axis.axhspan(-floor, floor, color=NOISE, alpha=0.2, lw=0, label="± noise floor")
            axis.axhline(0, color=MEASURED, lw=0.8)
            axis.set(title=f"joint {joint + 1}", xlabel=label)
        axes[0].set_ylabel(f"residual [{unit}]")
        axes[0].legend(frameon=False, fontsize=9)


def remains(folder: Path, about: str, found: Diagnosis) -> None:
    """What the last model leaves, over each quantity that it may depend on, and its spectrum where that tells."""
    pairs = zip(found.material.datasets, found.ladder.computed, strict=True)
    left = compare(None, [Prediction(data, computed) for data, computed in pairs])
    curves(folder / "remains.png", f"What no effect explains, with its 95 % band and noise floor: {about}", left)
    if "frequency" in found.remainder.variables:
        spectra(folder / "remains_spectrum.png", f"What no effect explains, by frequency: {about}", left)


def _curve(axis: Any, x: Floats, y: Floats, colour: str, name: str) -> None:
    """Samples, thinned out, and their mean in bins."""
    drawn = signature.binned(x, y)
    axis.plot(drawn.x, drawn.y, ".", ms=1.2, color=colour, alpha=0.25, zorder=1)
    axis.plot(drawn.centre, drawn.mean, color=colour, lw=1.8, label=name, zorder=3)
