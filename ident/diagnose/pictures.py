"""A diagnosis as pictures: the ladder, and every finding over the quantity in which it shows."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ident.dataset import Dataset
from ident.diagnose.diagnosis import Diagnosis
from ident.diagnose.document import Document
from ident.diagnose.rungs import Finding
from ident.plots import COMPUTED, MEASURED, NOMINAL, figure
from recordings.recording import Floats

NOISE = "#009E73"
"""Of Okabe and Ito's palette, as the others."""
BINS = 40
_LEAST = 8
"""Samples in a bin; others are left out."""


def draw(found: Diagnosis, document: Document, folder: Path) -> None:
    """Draw into `folder`, which is made."""
    folder.mkdir(parents=True, exist_ok=True)
    about = ", ".join(document.recordings)
    ladder(folder / "ladder.png", f"{document.verdict}: {about}", document)
    for number, one in enumerate(found.ladder.findings, start=1):
        finding(folder / f"finding_{number}_{one.term.name}.png", found, one)


def ladder(path: Path, title: str, document: Document) -> None:
    """Training and held-out error of each rung, joint by joint, and the noise floor as the line to reach."""
    dof = len(document.joints)
    names = [f"+ {rung.added}" if rung.added else "base model" for rung in document.rungs]
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
            x, label = over(axis_name, datasets, found.ladder.computed, joint)
            for residuals, colour, name in ((one.without, NOMINAL, "without"), (one.with_it, COMPUTED, "with")):
                _curve(axis, x, np.concatenate([part[:, joint] for part in residuals]), colour, name)
            floor = found.ladder.floor.rms[joint]
            axis.axhspan(-floor, floor, color=NOISE, alpha=0.2, lw=0, label="± noise floor")
            axis.axhline(0, color=MEASURED, lw=0.8)
            axis.set(title=f"joint {joint + 1}", xlabel=label)
        axes[0].set_ylabel(f"residual [{unit}]")
        axes[0].legend(frameon=False, fontsize=9)


def over(axis: str, datasets: Sequence[Dataset], computed: Sequence[Floats], joint: int) -> tuple[Floats, str]:
    """The quantity `axis` of a joint in all rows (m,) of all recordings, and its name with its unit."""
    unit = datasets[0].recording.rig.position_units[joint]
    effort = datasets[0].recording.rig.effort_units[joint]
    sources: dict[str, tuple[list[Floats], str]] = {
        "position": ([data.motion.position[:, joint] for data in datasets], f"position [{unit}]"),
        "motor angle": ([data.motion.position[:, joint] for data in datasets], f"position [{unit}]"),
        "velocity": ([data.motion.velocity[:, joint] for data in datasets], f"velocity [{unit}/s]"),
        "acceleration": ([data.motion.acceleration[:, joint] for data in datasets], f"acceleration [{unit}/s²]"),
        "load": ([torque[:, joint] for torque in computed], f"computed load [{effort}]"),
        "time": ([data.time for data in datasets], "time [s]"),
    }
    values, label = sources[axis]
    return np.concatenate(values), label


def _curve(axis: Any, x: Floats, y: Floats, colour: str, name: str) -> None:
    """Samples, thinned out, and the mean in bins of equal width with its 95 % band (neighbours taken as alike)."""
    known = np.isfinite(x) & np.isfinite(y)
    x, y = x[known], y[known]
    thin = slice(None, None, max(1, len(x) // 3000))
    axis.plot(x[thin], y[thin], ".", ms=1.2, color=colour, alpha=0.25, zorder=1)
    edges = np.linspace(x.min(), x.max(), BINS + 1)
    number = np.clip(np.digitize(x, edges) - 1, 0, BINS - 1)
    count = np.bincount(number, minlength=BINS)
    enough = count >= _LEAST
    mean = np.bincount(number, y, BINS)[enough] / count[enough]
    centre = np.bincount(number, x, BINS)[enough] / count[enough]
    axis.plot(centre, mean, color=colour, lw=1.8, label=name, zorder=3)
