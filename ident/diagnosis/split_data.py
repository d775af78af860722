"""What a diagnosis works with: recordings, and which of their rows fits may see."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ident.data import noise
from ident.data.cycles import repeating
from ident.data.dataset import Dataset
from ident.data.prepared_recording import Course
from ident.dynamics.effects.base import Signal
from ident.dynamics.structure import Composition
from ident.estimation.nonlinear_fit import Solution, begun, improved
from ident.estimation.predicted_torque import KEPT, Evaluator
from recordings.recording import Bools, Floats

SEGMENTS = 15
"""Into so many parts a cycle is cut where there is no other recording to validate on; each third one is held out."""
_GUARDS = 5
"""A segment is so many times as long as what the filter makes its neighbours know of it, at least."""
MAX_STANDSTILL = 0.25
"""Rows with more standstill than this behind them are left out."""
MAX_AMPLIFICATION = 2.0
"""What is reported tells little of the torque where it makes an error of it larger than so many times."""
MIN_REPORTED_SHARE = 0.01
"""Share of rows up to which leaving them out is not worth a word, and those near saturation are judged as well."""
_DEVIATIONS = 3.0
"""Speeds within so many standard deviations of what encoder steps make of it are standstill."""
_CREEPING = 0.02
"""Of the largest speed: below it, dry friction is between its two levels in any machine."""
_LONG = 0.5
"""Share of creeping behind a row from which on this is a standstill, and no reversal on the way."""
_LEAST_KEPT = 8
"""Columns that each of many excerpts of long recordings remembers."""
_SEED = 0
"""The same verdict each time."""
_DRAWS = 4
"""Readings with other encoder steps that tell how well parameters are known."""
_SAME = 1e-10
"""Two angles closer than this are the same reading [rad or m]."""


@dataclass(frozen=True, eq=False)
class SplitData:
    """Recordings, each row of which is seen by fits, or held out, or neither."""

    predictors: tuple[Evaluator, ...]
    train: tuple[Bools, ...]
    """(m, dof) of each recording."""
    test: tuple[Bools, ...]
    """(m, dof) of each recording."""
    weights: tuple[Floats, ...]
    """(m, dof) of each recording [1 / (N m)]; 0 where it is not seen."""
    other_motion: bool
    """Whether what is held out is another recording; else phase segments of the same."""
    standstill_share: float = 0.0
    """Share of the rows that neither fits see nor are judged, as a joint stands still there."""
    insensitive_share: float = 0.0
    """Share of the rows that are not judged, as what is reported there tells little of the torque."""
    _misread: dict[tuple[str, ...], tuple[list[tuple[Floats, Floats]], Floats]] = field(
        default_factory=dict, repr=False
    )
    """What was worked out, by the names of effects."""

    @property
    def datasets(self) -> tuple[Dataset, ...]:
        """The measured rows."""
        return tuple(one.course.dataset for one in self.predictors)

    @property
    def scored(self) -> tuple[Bools, ...]:
        """(m, dof) of each recording: rows that are seen or held out."""
        return tuple(seen | held for seen, held in zip(self.train, self.test, strict=True))

    @cached_property
    def perturbed(self) -> tuple[Evaluator, ...]:
        """The recordings as they might have been read: with errors of half an encoder step at most, drawn by lot."""
        return tuple(Evaluator(_disturbed(one.course)) for one in self.predictors)

    @cached_property
    def perturbed_draws(self) -> tuple[tuple[Evaluator, ...], ...]:
        """Several such readings of the recordings of which fits see something."""
        courses = [self.predictors[i].course for i in self.train_indices]
        return tuple(tuple(Evaluator(_disturbed(one, 1 + draw)) for one in courses) for draw in range(_DRAWS))

    @cached_property
    def repeating_share(self) -> tuple[Floats, ...]:
        """(dof,) of each recording: share of the finest part of its motion that is the same in all repetitions."""
        return tuple(repeating(one.course) for one in self.predictors)

    def perturbed_regressors(self, bare: Composition) -> tuple[list[tuple[Floats, Floats]], Floats]:
        """Columns (m, dof, K) of a `bare` composition for each recording, as it was read and as it might have been,
        and (K, K) what a fit to the second makes of parameters: so much more of each per unit of its own.

        Errors in a regressor make a fit believe it less: where the steps are coarse, inertias come out too small.
        """
        names = tuple(term.name for term in bare.terms)
        if names not in self._misread:
            x = np.zeros(len(bare.named))
            both = zip(self.predictors, self.perturbed, strict=True)
            pairs = [(one.linearised(bare, x)[1], other.linearised(bare, x)[1]) for one, other in both]
            self._misread[names] = pairs, self._misled(pairs)
        return self._misread[names]

    def _misled(self, pairs: Sequence[tuple[Floats, Floats]]) -> Floats:
        """(K, K) of `misread`, by weighted least squares over the rows that fits see."""
        rows, changed = [], []
        for weight, (one, other) in zip(self.weights, pairs, strict=True):
            known = (weight > 0) & np.isfinite(one).all(axis=2) & np.isfinite(other).all(axis=2)
            rows.append((other * weight[:, :, None])[known])
            changed.append(((one - other) * weight[:, :, None])[known])
        size = np.sqrt((np.concatenate(rows) ** 2).sum(axis=0))
        size[size == 0] = 1.0
        found = np.linalg.lstsq(np.concatenate(rows) / size, np.concatenate(changed), rcond=1e-10)[0]
        misled: Floats = found / size[:, None]
        return misled

    @cached_property
    def train_indices(self) -> tuple[int, ...]:
        """Recordings of which fits see something."""
        return tuple(i for i, seen in enumerate(self.train) if seen.any())

    @cached_property
    def independent_rows(self) -> float:
        """How many independent rows the seen ones are worth: a low-pass makes neighbours alike."""
        return sum(
            float(self.train[i].sum()) * min(1.0, 2 * self.datasets[i].bandwidth / self.datasets[i].rate)
            for i in self.train_indices
        )

    @cached_property
    def torque_rms(self) -> Floats:
        """(dof,) measured torque [N m] over all rows."""
        return rms([dataset.torque for dataset in self.datasets], self.scored)

    def fit(self, composition: Composition, x: Floats) -> Solution:
        """`composition` fitted to what may be seen, from `x` (K,)."""
        return self.refine(self.fit_linear(composition, x))

    def fit_linear(self, composition: Composition, x: Floats) -> Solution:
        """The linear parameters of `composition` fitted to what may be seen, the others as in `x` (K,)."""
        return begun(self._fitted, composition, x, self._own_weights)

    def refine(self, solution: Solution) -> Solution:
        """All parameters fitted, beginning with those of a `solution`."""
        return improved(self._fitted, solution, self._own_weights)

    @property
    def _fitted(self) -> list[Evaluator]:
        return [self.predictors[i] for i in self.train_indices]

    @property
    def _own_weights(self) -> list[Floats]:
        return [self.weights[i] for i in self.train_indices]

    def without_saturated_rows(self, solution: Solution, error: Floats) -> "SplitData":
        """Without judging rows in which what is reported tells little of the torque, if they are worth mentioning.

        In saturation any error of the torque is amplified. Fits still see them: nothing else tells where it begins.

        error: (dof,) of the torque [N m], as small as may be found.
        """
        if not any(isinstance(term.effect, Signal) and term.effect.report for term in solution.composition.terms):
            return self
        amplified = [one.amplification(solution.composition, solution.x, error) for one in self.predictors]
        silent = [
            one.course.condition(np.where(np.isfinite(size), size > MAX_AMPLIFICATION, np.nan).astype(float)) > MAX_STANDSTILL
            for one, size in zip(self.predictors, amplified, strict=True)
        ]
        seen, held = (
            tuple(rows & ~left for rows, left in zip(part, silent, strict=True)) for part in (self.train, self.test)
        )
        before, after = (sum(int(rows.sum()) for rows in (*a, *b)) for a, b in ((self.train, self.test), (seen, held)))
        share = 1 - after / before
        return replace(self, seen=seen, held=held, silent=share) if share > MIN_REPORTED_SHARE else self

    def residuals(self, solution: Solution) -> tuple[Floats, ...]:
        """(m, dof) measured minus computed, of every recording [N m]."""
        composition, x = solution.composition, solution.x
        return tuple(one.course.dataset.torque - one.torque(composition, x) for one in self.predictors)


def split_recordings(train: Sequence[Course], validate: Sequence[Course]) -> SplitData:
    """The material of recordings to fit, and of those, if there are, that fits must not see."""
    courses = [*train, *validate]
    still = [standstill_share(course) for course in courses]
    moving = [course.usable & (part < MAX_STANDSTILL) for course, part in zip(courses, still, strict=True)]
    if validate:
        nothing = [np.zeros_like(course.usable) for course in courses]
        seen = moving[: len(train)] + nothing[len(train) :]
        held = nothing[: len(train)] + moving[len(train) :]
    else:
        seen, held = (list(part) for part in zip(*map(_by_phase, train, moving), strict=True))
    weights = _weights([course.dataset for course in courses], seen, still)
    evaluators = tuple(Evaluator(course, max(_LEAST_KEPT, KEPT // len(courses))) for course in courses)
    usable = sum(int(course.usable.sum()) for course in courses)
    at_rest = 1 - sum(int(rows.sum()) for rows in moving) / max(usable, 1)
    return SplitData(evaluators, tuple(seen), tuple(held), tuple(weights), bool(validate), at_rest)


def rms(residuals: Sequence[Floats], chosen: Sequence[Bools]) -> Floats:
    """(dof,) of the `chosen` rows (m, dof) of all recordings, as far as the model says anything of them."""
    known = [which & np.isfinite(r) for r, which in zip(residuals, chosen, strict=True)]
    squares = sum(np.where(which, r**2, 0.0).sum(axis=0) for r, which in zip(residuals, known, strict=True))
    count = sum(which.sum(axis=0) for which in known)
    result: Floats = np.sqrt(squares / np.maximum(count, 1))
    return result


def _by_phase(course: Course, usable: Bools) -> tuple[Bools, Bools]:
    """Seen and held-out rows: the same phase segments of all cycles, a filter's length away from each other.

    Whole cycles would leak: any function of phase that fits one cycle of a repeated motion fits the next.
    """
    dataset = course.dataset
    phase = dataset.phase if np.isfinite(dataset.phase).any() else dataset.time
    longest, reach = max(float(np.nanmax(phase)), 1 / dataset.rate), 1.5 / dataset.bandwidth
    segments = 3 * max(1, min(SEGMENTS // 3, int(longest / (3 * _GUARDS * reach))))
    place = phase * segments / longest
    held = np.floor(place) % 3 == 2  # where there is no phase, nothing is seen, nor held out
    guard = reach * segments / longest
    into = place % 3
    near = (np.abs(into - 2) < guard) | (into > 3 - guard) | (into < guard)
    known = np.isfinite(place)
    return usable & (known & ~held & ~near)[:, None], usable & (held & ~near)[:, None]


def _weights(datasets: Sequence[Dataset], seen: Sequence[Bools], doubt: Sequence[Floats]) -> list[Floats]:
    """1 / standard deviation of each row, by the noise, what a first fit of the mechanism leaves, and standstill."""
    fitting = [i for i, one in enumerate(seen) if one.any()]
    regressor = np.concatenate([datasets[i].regressor[seen[i]] for i in fitting])
    torque = np.concatenate([datasets[i].torque[seen[i]] for i in fitting])
    parameters = np.linalg.lstsq(regressor, torque, rcond=None)[0]
    residuals = [dataset.torque - dataset.regressor @ parameters for dataset in datasets]
    found = noise.estimate(datasets, residuals)
    return [
        np.where(rows, 1 / np.hypot(noise.residual_std(dataset, residual, found), friction), 0.0)
        for dataset, residual, rows, friction in zip(datasets, residuals, seen, doubt, strict=True)
    ]


def standstill_share(course: Course) -> Floats:
    """(m, dof) share of the instants behind a row at which a joint moves too slowly to tell in which direction.

    Dry friction may then be anything between its two levels. How slow that is follows from the encoder's steps.
    """
    motion, read = course.path.motion, _disturbed(course).path.motion
    slowest = _DEVIATIONS * np.nanstd(read.velocity - motion.velocity, axis=0)
    speed = np.abs(motion.velocity)
    unsure, creeping = (
        np.clip(course.condition(np.where(np.isfinite(speed), speed < limit, np.nan)), 0.0, 1.0)
        for limit in (slowest, _CREEPING * np.nanmax(speed, axis=0))
    )
    return np.maximum(unsure, np.where(creeping > _LONG, creeping, 0.0))


def _disturbed(course: Course, seed: int = _SEED) -> Course:
    """As if its encoders had other steps of the same size."""
    measured = course.samples.position
    error = np.random.default_rng(seed).uniform(-0.5, 0.5, measured.shape) * encoder_resolution(measured)
    path = course.corrected(course.path.rig, lambda position: position + error)
    return replace(course, samples=replace(course.samples, position=measured + error), path=path)


def encoder_resolution(position: Floats) -> Floats:
    """(dof,) step between neighbouring readings of the encoders that gave `position` (n, dof) [rad or m]."""
    steps = []
    for signal in position.T:
        apart = np.diff(np.unique(signal[np.isfinite(signal)]))
        apart = apart[apart > _SAME]
        steps.append(float(apart.min()) if len(apart) else 0.0)
    return np.array(steps)
