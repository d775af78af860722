"""The line that the error of a right model reaches: the noise, and what the encoders' steps leave that repeats.

The noise is what differs between repetitions of the motion. Errors that the steps of an encoder make may be the same
in each repetition, and then look like something that the model lacks; so how much of that there can be is worked out.
An error of half a step at most, evenly spread, is added to the measured motion, and what comes of it in the torque is
looked at: in the motion that is judged, and in the parameters, for errors in a regressor lead a fit astray. The share
of it that repeats is that of the finest part of the measured motion, which is hardly anything else than such errors.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ident import filters
from ident.data import cycle_statistics, noise
from ident.data.cycle_statistics import Trend
from ident.data.cycles import by_cycle
from ident.data.spectral_lines import Line, lines
from ident.diagnosis.split_data import SplitData, rms
from ident.estimation.nonlinear_fit import Solution
from ident.estimation.predicted_torque import Evaluator
from recordings.recording import Bools, Floats

_LEAST = 0.3
"""A vibration may be no more than all of the noise, but for this share of its RMS."""
_ABOVE = (1.3, 2.2)
"""The band in which encoder steps are seen alone, over the bandwidth of the analysis."""
_MOST = 4.0
"""They are not taken to leave more than this many times what is expected."""
_FEW = 3.0
"""No row counts for more than so many times the typical one."""
_TINY = 1e-24


@dataclass(frozen=True, eq=False)
class NoiseFloor:
    """Of each joint, within the analysis bandwidth."""

    noise: Floats
    """(dof,) RMS of what differs between repetitions, without a trend [N m]."""
    encoder: Floats
    """(dof,) RMS of what encoder steps leave that repeats [N m]."""
    lines: tuple[Line | None, ...]
    """Vibration of each joint, which is no noise."""
    trends: tuple[Trend | None, ...]
    """What changes steadily from one repetition to the next, if it is more than chance."""

    @property
    def rms(self) -> Floats:
        """(dof,) both together [N m]."""
        together: Floats = np.hypot(self.noise, self.encoder)
        return together


def estimate_noise_floor(material: SplitData, solution: Solution, residuals: Sequence[Floats]) -> NoiseFloor:
    """The floor under the `residuals` (m, dof) of a `solution`."""
    splits = cycle_statistics.of(material.datasets, residuals)
    if splits:
        level = np.array([one.noise_rms for one in splits])
        found = lines(material.datasets, residuals)
        vibration = np.array([line.mean_square if line else 0.0 for line in found])
        level = np.sqrt(np.maximum(level**2 - vibration, (_LEAST * level) ** 2))
        trends = tuple(one.trend if one.trend and one.trend.significant else None for one in splits)
    else:
        found, trends = (None,) * residuals[0].shape[1], (None,) * residuals[0].shape[1]
        measured = noise.estimate(material.datasets, residuals)
        std = [
            np.stack([own.torque_std(data.volt_sensitivity[:, j]) for j, own in enumerate(measured)], axis=1)
            for data in material.datasets
        ]
        level = rms(std, [one.course.usable for one in material.predictors])
    kept, refitted = _misread(material, solution)
    judged = material.scored
    parts = [
        _encoder(
            evaluator,
            material.perturbed[i],
            judged[i],
            material.repeating_share[i],
            kept[i],
            refitted[i],
            solution,
        )
        for i, evaluator in enumerate(material.predictors)
    ]
    return NoiseFloor(level, np.sqrt(np.mean(parts, axis=0)), found, trends)


def _misread(material: SplitData, solution: Solution) -> tuple[list[Floats], list[Floats]]:
    """What other steps of the encoders would change, by the mechanism alone: (m, dof) of each recording [N m].

    Once with the parameters of the `solution`, and once with those that a fit to the readings with other steps gives.
    """
    composition = solution.composition
    always = tuple(term for term in composition.terms if term.effect.always_true)
    own = composition.load(solution.x)
    columns, misled = material.perturbed_regressors(replace(composition, terms=always))
    kept = [(other - one) @ own for one, other in columns]
    return kept, [same + other @ (misled @ own) for same, (_, other) in zip(kept, columns, strict=True)]


def _encoder(
    evaluator: Evaluator,
    disturbed: Evaluator,
    judged: Bools,
    repeating: Floats,
    kept: Floats,
    refitted: Floats,
    solution: Solution,
) -> Floats:
    """(dof,) mean square [(N m)^2] of what the encoders' steps leave in the torque that repeats.

    disturbed: the same recording as it might have been read with other steps. Some effects make more of them than
    the mechanism by itself, which `kept` and `refitted` (m, dof) are of; by how much is told by the rows that are
    `judged` (m, dof), none of which counts for much more than usual: an amplifier near its limit makes anything of
    them.
    """
    course, composition, x = evaluator.course, solution.composition, solution.x
    difference = disturbed.unfiltered(composition, x) - evaluator.unfiltered(composition, x)
    seen, alone = (_limited(np.where(judged, one, np.nan)) for one in (course.condition(difference), kept))
    more = np.maximum(seen / np.maximum(alone, _TINY), 1.0)
    expected: Floats = np.nanmean(np.where(course.usable, refitted, np.nan) ** 2, axis=0) * more
    if len(difference) != len(course.samples.position):  # a mean cycle: nothing tells more
        return expected
    known: Floats = expected * repeating * _amplified(evaluator, solution, difference, repeating)
    return known


def _amplified(evaluator: Evaluator, solution: Solution, expected: Floats, repeating: Floats) -> Floats:
    """(dof,) how much larger the mean square of what encoder steps leave is than that of the `expected` (n, dof).

    The position loop answers to the steps too, so that they are not as evenly spread as errors drawn by lot. Judged
    in the band above the analysis, where hardly anything else repeats; by medians, for peaks may be something else.
    """
    course = evaluator.course
    left = course.samples.torque - evaluator.unfiltered(solution.composition, solution.x)
    low, high = (min(factor * course.dataset.bandwidth, course.samples.rate / 5) for factor in _ABOVE)
    if high < 1.2 * low:
        return np.ones(left.shape[1])
    repeated, drawn = (
        by_cycle(
            course,
            filters.convolve(x, filters.low_pass(high, course.samples.rate))
            - filters.convolve(x, filters.low_pass(low, course.samples.rate)),
        )
        for x in (left, expected)
    )
    cycles = np.isfinite(repeated).sum(axis=0)
    known = (cycles > 1).all(axis=1)
    if len(repeated) < 2 or not known.any():
        return np.ones(left.shape[1])
    mean = np.nanmean(repeated[:, known], axis=0)
    differing = _typical(repeated[:, known] - mean) / (len(repeated) - 1)
    most = (_typical(mean) - differing) / np.maximum(_typical(drawn) * repeating, _TINY)
    return np.clip(most, 1.0, _MOST)


def _limited(x: Floats) -> Floats:
    """(dof,) mean square of `x` (m, dof), of which no value counts as more than a few times the typical one."""
    most = _FEW * np.sqrt(_typical(x))
    square: Floats = np.nanmean(np.minimum(np.abs(x), most) ** 2, axis=0)
    return square


def _typical(x: Floats) -> Floats:
    """(dof,) mean square of `x` (..., dof), from the median of its size."""
    return (np.nanmedian(np.abs(x.reshape(-1, x.shape[-1])), axis=0) / 0.6745) ** 2
