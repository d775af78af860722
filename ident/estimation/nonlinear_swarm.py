"""Particle swarm over the parameters in which a model is not linear: shapes and signal parameters of effects.

The objective of a particle is the minimum of (33) over all linear parameters, which is computed exactly.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.random import Generator

from ident.basics.threads import in_threads
from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.effects.base import is_infinite
from ident.dynamics.structure import ModelStructure, ParameterEntry, Term
from ident.estimation import particle_swarm
from ident.estimation.estimators import lad, pso
from ident.estimation.linear_fit import Fit, fit
from ident.estimation.problem import Progress
from ident.estimation.regression import linearize
from recordings.errors import BadInput, told
from recordings.recording import Bools, Floats, Ints

_MIN_ROWS = 0.5
"""Share of the rows for which a model must predict a torque; else its objective is infinite."""
_LOGARITHMIC = 100.0
"""Ratio of two positive limits from which a parameter is searched on a logarithmic scale."""


@dataclass(frozen=True, eq=False)
class SwarmSearch:
    """A model structure whose nonlinear parameters were searched."""

    structure: ModelStructure
    x: Floats
    """(K,)"""
    history: Floats
    """Best objective (33) [N m] before the first step and after each step."""
    evaluations: int
    """Number of models whose linear parameters were computed."""


@dataclass(frozen=True, eq=False)
class _SearchRegion:
    """Search region of d parameters, as a unit cube."""

    entries: Ints
    """(d,) in the vector of all parameters."""
    lower: Floats
    upper: Floats
    logarithmic: Bools

    def values(self, position: Floats) -> Floats:
        """Parameters (d,) at a `position` (d,) of the cube."""
        low = np.where(self.logarithmic, np.log(np.where(self.logarithmic, self.lower, 1.0)), self.lower)
        high = np.where(self.logarithmic, np.log(np.where(self.logarithmic, self.upper, 1.0)), self.upper)
        value = low + position * (high - low)
        return np.where(self.logarithmic, np.exp(np.where(self.logarithmic, value, 0.0)), value)


def search(
    recordings: Sequence[PreparedRecording],
    terms: Sequence[Term],
    settings: pso.Settings,
    generator: Generator,
    progress: Progress,
    physical: bool = False,
) -> SwarmSearch:
    """Search the nonlinear parameters of the effects `terms` in the whole of their physical range.

    physical: as in `ident.estimation.linear_fit.fit`. Where a shape has only certain values, as an index has, there
    is a swarm for each of them, and the best result is kept.

    Raises:
        BadInput: no parameter is nonlinear, or the range of one is not limited.
    """
    structure = replace(recordings[0].base_structure, terms=tuple(terms))
    duration = max(float(recording.time[-1]) for recording in recordings)
    region = _search_region(structure, duration)
    choices = list(_choices(structure))
    searches = []
    for done, chosen in enumerate(choices):
        objective = _Objective(recordings, structure, region, chosen, physical)
        history = _fly(objective, settings, generator, progress, (done, len(choices)))
        searches.append(SwarmSearch(structure, objective.best, history, objective.evaluations))
    best = min(searches, key=lambda result: float(result.history[-1]))
    if not np.isfinite(best.history[-1]):
        raise BadInput(
            "a model that predicts the torque somewhere in the range of its parameters expected, none found by the "
            "swarm; give it more particles, or choose other effects"
        )
    return replace(best, evaluations=sum(result.evaluations for result in searches))


def _fly(
    objective: "_Objective",
    settings: pso.Settings,
    generator: Generator,
    progress: Progress,
    part: tuple[int, int],
) -> Floats:
    """Let one swarm fly and return its history; `part`: number of swarms before this one, and of all."""
    bounds = np.tile([0.0, 1.0], (len(objective.region.entries), 1))
    history: list[float] = []
    swarm_states = particle_swarm.flight(objective, bounds, generator, settings, pso.topology(settings))
    for step, swarm in enumerate(swarm_states):
        history.append(float(swarm.personal_value.min()))
        progress(part[0] * settings.iterations + max(step, 1), part[1] * settings.iterations)
        if swarm.personal_value.max() <= (1 + settings.tolerance) * history[-1]:
            break
    return np.array(history)


class _Objective:
    """The minimum of (33) over the linear parameters, as a function of the nonlinear ones."""

    def __init__(
        self,
        recordings: Sequence[PreparedRecording],
        structure: ModelStructure,
        region: _SearchRegion,
        chosen: Floats,
        physical: bool,
    ) -> None:
        """`chosen`: (K,) shapes that have only certain values, and zeros."""
        self.region = region
        self.best = chosen
        self.evaluations = 0
        self._best_value = np.inf
        self._recordings, self._structure, self._chosen, self._physical = recordings, structure, chosen, physical
        self._rows = sum(int(recording.usable.sum()) for recording in recordings)
        # What distorts the torque, or depends on the load, is linear only around a solution.
        depends = any(effect.report for _, _, effect in structure.signals) or any(
            term.effect.axis == "load" for term in structure.terms
        )
        self._passes = 2 if depends else 1

    def __call__(self, positions: Floats) -> Floats:
        """Values (n,) at `positions` (n, d) of the unit cube."""
        models = in_threads(self._solved, positions)
        values = np.array([value for _, value in models])
        self.evaluations += len(models)
        if values.min() < self._best_value:
            self.best, self._best_value = models[int(values.argmin())]
        return values

    def _solved(self, position: Floats) -> tuple[Floats, float]:
        """All parameters (K,) at a `position` (d,), and the value of (33)."""
        x = self.best.copy()  # the linear parameters of the best model so far, around which others are linear
        nonlinear = ~self._structure.linear
        x[nonlinear] = self._chosen[nonlinear]
        x[self.region.entries] = self.region.values(position)
        for _ in range(self._passes):
            try:
                fitted = self._fit(x)
            except BadInput:  # a column vanishes, or no row is left
                return x, np.inf
            x[self._structure.linear] = fitted.parameters
        if fitted.rows < _MIN_ROWS * self._rows:
            return x, np.inf
        # As if the rows without a prediction were like the others.
        return x, fitted.estimate.objective * self._rows / fitted.rows

    def _fit(self, x: Floats) -> Fit:
        regressions = [linearize(recording, self._structure, x) for recording in self._recordings]
        parameters, generator = self._structure.linear_parameters, np.random.default_rng(0)
        return fit(regressions, parameters, "lad", lad.Settings(), generator, lambda *_: None, self._physical)


def _search_region(structure: ModelStructure, duration: float) -> _SearchRegion:
    """Physical range of all searched parameters; times end with the recording, after `duration` [s]."""
    searched = [(index, entry) for index, entry in enumerate(structure.parameters) if entry.free and not entry.linear]
    if not searched:
        raise BadInput(
            "method pso_nonlinear: an effect with shapes or signal parameters, such as "
            + told("--with stribeck", 'effects="stribeck"')
            + ", expected, none found; add one, or choose lad"
        )
    lower, upper = (np.array(limits) for limits in zip(*(_limits(e, duration) for _, e in searched), strict=True))
    logarithmic = (lower > 0) & (upper >= _LOGARITHMIC * np.maximum(lower, np.finfo(float).tiny))
    return _SearchRegion(np.array([index for index, _ in searched]), lower, upper, logarithmic)


def _limits(entry: ParameterEntry, duration: float) -> tuple[float, float]:
    upper = duration if is_infinite(entry.upper, entry.unit) else entry.upper
    if not (np.isfinite(entry.lower) and np.isfinite(upper)):
        raise BadInput(
            f"method pso_nonlinear: parameters with a limited range expected, {entry.name} without one found; choose "
            "another method"
        )
    return entry.lower, upper


def _choices(structure: ModelStructure) -> Iterator[Floats]:
    """Vectors (K,) with each combination of the shapes that have only certain values; zeros elsewhere."""
    fixed: list[tuple[int, tuple[float, ...]]] = []
    for index, term in enumerate(structure.terms):
        entries = np.flatnonzero(structure.parameter_mask(index))[-len(term.shapes) or None :]
        for entry, shape in zip(entries.tolist(), term.shapes, strict=False):
            if not shape.searched:
                if not shape.initial_guesses:
                    raise BadInput(
                        f"method pso_nonlinear: effects whose shapes can be searched expected, {term.name} found, "
                        f"whose {shape.name} comes from the data; choose another method"
                    )
                fixed.append((entry, shape.initial_guesses))
    for values in product(*(guesses for _, guesses in fixed)):
        x = np.zeros(len(structure.parameters))
        x[[entry for entry, _ in fixed]] = values
        yield x
