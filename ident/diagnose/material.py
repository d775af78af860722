"""What a diagnosis works with: recordings, and which of their rows fits may see."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident import noise
from ident.composition import Composition
from ident.course import Course
from ident.dataset import Dataset
from ident.evaluation import Evaluator
from ident.refine import Solution, refine
from recordings.recording import Bools, Floats

SEGMENTS = 15
"""Into so many parts a cycle is cut where there is no other recording to validate on; each third one is held out."""


@dataclass(frozen=True, eq=False)
class Material:
    """Recordings, each row of which is seen by fits, or held out, or neither."""

    evaluators: tuple[Evaluator, ...]
    seen: tuple[Bools, ...]
    """(m, dof) of each recording."""
    held: tuple[Bools, ...]
    """(m, dof) of each recording."""
    weights: tuple[Floats, ...]
    """(m, dof) of each recording [1 / (N m)]; 0 where it is not seen."""
    other_motion: bool
    """Whether what is held out is another recording; else phase segments of the same."""

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """The measured rows."""
        return tuple(one.course.dataset for one in self.evaluators)

    @cached_property
    def fitting(self) -> tuple[int, ...]:
        """Recordings of which fits see something."""
        return tuple(i for i, seen in enumerate(self.seen) if seen.any())

    @cached_property
    def independent_rows(self) -> float:
        """How many independent rows the seen ones are worth: a low-pass makes neighbours alike."""
        return sum(
            float(self.seen[i].sum()) * min(1.0, 2 * self.datasets[i].bandwidth / self.datasets[i].rate)
            for i in self.fitting
        )

    @cached_property
    def torque_rms(self) -> Floats:
        """(dof,) measured torque [N m] over all rows."""
        return rms([dataset.torque for dataset in self.datasets], [a | b for a, b in zip(self.seen, self.held)])

    def solve(self, composition: Composition, x: Floats) -> Solution:
        """`composition` fitted to what may be seen, from `x` (K,)."""
        return refine(
            [self.evaluators[i] for i in self.fitting], composition, x, [self.weights[i] for i in self.fitting]
        )

    def residuals(self, solution: Solution) -> tuple[Floats, ...]:
        """(m, dof) measured minus computed, of every recording [N m]."""
        composition, x = solution.composition, solution.x
        return tuple(
            one.course.dataset.torque - one.torque(composition, x, x[composition.entries(-1)])
            for one in self.evaluators
        )


def gather(train: Sequence[Course], validate: Sequence[Course]) -> Material:
    """The material of recordings to fit, and of those, if there are, that fits must not see."""
    courses = [*train, *validate]
    if validate:
        nothing = [np.zeros_like(course.usable) for course in courses]
        usable = [course.usable for course in courses]
        seen = usable[: len(train)] + nothing[len(train) :]
        held = nothing[: len(train)] + usable[len(train) :]
    else:
        seen, held = (list(part) for part in zip(*(_by_phase(course) for course in train), strict=True))
    weights = _weights([course.dataset for course in courses], seen)
    evaluators = tuple(Evaluator(course) for course in courses)
    return Material(evaluators, tuple(seen), tuple(held), tuple(weights), bool(validate))


def rms(residuals: Sequence[Floats], chosen: Sequence[Bools]) -> Floats:
    """(dof,) of the `chosen` rows (m, dof) of all recordings."""
    squares = sum(np.where(which, r**2, 0.0).sum(axis=0) for r, which in zip(residuals, chosen, strict=True))
    count = sum(which.sum(axis=0) for which in chosen)
    result: Floats = np.sqrt(squares / np.maximum(count, 1))
    return result


def _by_phase(course: Course) -> tuple[Bools, Bools]:
    """Seen and held-out rows: the same phase segments of all cycles, a filter's length away from each other.

    Whole cycles would leak: any function of phase that fits one cycle of a repeated motion fits the next.
    """
    dataset = course.dataset
    phase = np.where(np.isfinite(dataset.phase), dataset.phase, dataset.time)
    length = max(float(np.nanmax(phase)), 1 / dataset.rate) / SEGMENTS
    place = phase / length
    held = np.floor(place) % 3 == 2
    guard = 1.5 / dataset.bandwidth / length
    into = place % 3
    near = (np.abs(into - 2) < guard) | (into > 3 - guard) | (into < guard)
    return course.usable & (~held & ~near)[:, None], course.usable & (held & ~near)[:, None]


def _weights(datasets: Sequence[Dataset], seen: Sequence[Bools]) -> list[Floats]:
    """1 / standard deviation of each row, by the noise and what a first fit of the mechanism leaves."""
    fitting = [i for i, one in enumerate(seen) if one.any()]
    regressor = np.concatenate([datasets[i].regressor[seen[i]] for i in fitting])
    torque = np.concatenate([datasets[i].torque[seen[i]] for i in fitting])
    parameters = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    residuals = [dataset.torque - dataset.regressor @ parameters for dataset in datasets]
    found = noise.estimate(datasets, residuals)
    return [
        np.where(rows, 1 / noise.residual_std(dataset, residual, found), 0.0)
        for dataset, residual, rows in zip(datasets, residuals, seen, strict=True)
    ]
