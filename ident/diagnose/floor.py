"""The line that the error of a right model reaches: the noise, and what the encoders' steps leave that repeats.

The noise is what differs between repetitions of the motion. Errors that the steps of an encoder make may be the same
in each repetition, and then look like something that the model lacks; so how much of that there can be is worked out.
An error of half a step at most, evenly spread, is added to the measured motion, and what comes of it in the torque is
looked at. The share of it that repeats is that of the finest part of the measured motion, which is hardly anything
else than such errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident import noise, repetition
from ident.course import Course
from ident.diagnose.material import Material, resolution, rms
from ident.refine import Solution
from recordings.recording import Floats

_SEED = 0
"""The same floor each time."""


@dataclass(frozen=True, eq=False)
class Floor:
    """Of each joint, within the analysis bandwidth."""

    noise: Floats
    """(dof,) RMS of what differs between repetitions, without a trend [N m]."""
    encoder: Floats
    """(dof,) RMS of what encoder steps leave that repeats [N m]."""

    @property
    def rms(self) -> Floats:
        """(dof,) both together [N m]."""
        together: Floats = np.hypot(self.noise, self.encoder)
        return together


def floor(material: Material, solution: Solution, residuals: Sequence[Floats]) -> Floor:
    """The floor under the `residuals` (m, dof) of a `solution`."""
    splits = repetition.of(material.datasets, residuals)
    if splits:
        level = np.array([one.noise_rms for one in splits])
    else:
        found = noise.estimate(material.datasets, residuals)
        std = [
            np.stack([own.torque_std(data.volt_sensitivity[:, j]) for j, own in enumerate(found)], axis=1)
            for data in material.datasets
        ]
        level = rms(std, [one.course.usable for one in material.evaluators])
    parts = [_encoder(one.course, solution) for one in material.evaluators]
    return Floor(level, np.sqrt(np.mean(parts, axis=0)))


def _encoder(course: Course, solution: Solution) -> Floats:
    """(dof,) mean square [(N m)^2] of what the encoders' steps leave in the torque that repeats."""
    measured = course.samples.position
    step = resolution(measured)
    error = np.random.default_rng(_SEED).uniform(-0.5, 0.5, measured.shape) * step
    own = solution.x[solution.composition.entries(-1)]
    read = course.corrected(course.path.rig, lambda position: position + error)
    difference = course.condition(read.regressor - course.path.regressor) @ own
    return np.nanmean(np.where(course.usable, difference, np.nan) ** 2, axis=0) * _repeating(course)


def _repeating(course: Course) -> Floats:
    """(dof,) share of the finest part of the measured motion that is the same in all repetitions, 0 to 1."""
    samples, smooth = course.samples, course.path.motion.position
    if len(smooth) != len(samples.position):
        return np.ones(smooth.shape[1])
    every = replace(course.dataset, repeat=samples.repeat, phase=samples.phase, rate=samples.rate)
    splits = repetition.split(repetition.by_cycle(every, samples.position - smooth))
    if splits is None:
        return np.ones(smooth.shape[1])
    return np.array([min(max(one.repeating / one.total, 0.0), 1.0) if one.total else 0.0 for one in splits])
