"""Search for the best excitation: sequential quadratic programming from several random starts."""

from bisect import bisect_left
from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
from numpy.random import Generator

from ident.design.problem import Criterion, DesignProblem
from ident.dynamics.mechanisms import Mechanism
from ident.estimation.problem import Progress
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import checks, kinematics
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble

RANDOM_STARTS = 16
"""Number of random motions that are evaluated."""
SHORT_RUNS = 8
"""Number of the best random motions that are optimised briefly."""
SHORT_ITERATIONS = 25
"""Iterations of each short optimisation."""
LONG_RUNS = 3
"""Number of the best results that are optimised further; the best of these is the design."""
LONG_ITERATIONS = 120
"""Iterations of each further optimisation."""
TOTAL_ITERATIONS = SHORT_RUNS * SHORT_ITERATIONS + LONG_RUNS * LONG_ITERATIONS
"""Maximum number of all iterations."""
OBJECTIVE_SCALE = 0.03
"""Factor of the objective: the first steps of the search are as long as its gradient and must not be too long."""
MARGIN = 0.95
"""Maximum used share of each limit."""
SLACK = 0.005
"""Allowed excess over MARGIN during the search; the result is scaled down at the end."""
START_USAGE = (0.3, 0.9)
"""Range of the used share of the limits at the start."""
HARMONIC_DECAY = (1.0, 3.0)
"""Range of the exponent p at the start: amplitudes of the harmonics n decrease as n^-p (1: equal speeds)."""
CENTRE_OFFSET = 0.5
"""Maximum offset of a start's centre from the middle, relative to half of the allowed range."""


def search(
    rig: Rig,
    mechanism: Mechanism,
    criterion: Criterion,
    period: float,
    harmonics: int,
    generator: Generator,
    progress: Progress,
) -> FourierSeries:
    """Return the best motion, a Fourier series of `harmonics` with the `period` [s] in every joint.

    Raises:
        BadInput: there is no motion within the limits.
    """
    problem = DesignProblem(rig, mechanism, criterion, period, harmonics, np.ones(len(mechanism.parameters)))
    starts = _initial_guesses(problem, generator)
    if criterion != "t":  # the columns of criterion "t" are normalized already
        problem = replace(problem, scale=np.maximum(problem.column_sizes(starts[0]), 1e-9))
    steps = count(1)
    for runs, iterations in ((SHORT_RUNS, SHORT_ITERATIONS), (LONG_RUNS, LONG_ITERATIONS)):
        starts = sorted(starts, key=partial(_objective, problem))[:runs]
        starts = [
            _optimized(problem, start, iterations, lambda: progress(next(steps), TOTAL_ITERATIONS))
            for start in starts
        ]
    return _within_limits(problem.series(min(starts, key=partial(_objective, problem))), rig)


def random_motion(
    rig: Rig, mechanism: Mechanism, period: float, harmonics: int, generator: Generator
) -> FourierSeries:
    """Return a random motion of the same kind.

    Raises:
        BadInput: there is no motion within the limits.
    """
    problem = DesignProblem(rig, mechanism, "d", period, harmonics, np.ones(len(mechanism.parameters)))
    return _within_limits(problem.series(_initial_guesses(problem, generator)[0]), rig)


def _objective(problem: DesignProblem, coefficients: Floats) -> float:
    return float(problem.evaluate(coefficients[None])[0][0])


def _initial_guesses(problem: DesignProblem, generator: Generator) -> list[Floats]:
    """RANDOM_STARTS random motions (v,), or fewer if there is no room around some of the centres.

    Raises:
        BadInput: there is no room around any centre.
    """
    starts = [_start(problem, centre, generator) for centre in _centres(problem.rig, generator)]
    possible = [start for start in starts if start is not None]
    if not possible:
        raise BadInput(
            f"rig '{problem.rig.name}': limits that leave room to move around the joint positions "
            f"{np.round(_middle(problem.rig), 3).tolist()} expected, none found; check the limits in the rig file"
        )
    return possible


def _start(problem: DesignProblem, centre: Floats, generator: Generator) -> Floats | None:
    """Random coefficients (v,) around the joint positions `centre` (dof,); None if there is no room."""
    dof, harmonics = problem.rig.dof, problem.harmonics
    decay = generator.uniform(*HARMONIC_DECAY)
    waves = generator.normal(size=(2, dof, harmonics)) / np.arange(1, harmonics + 1) ** decay
    waves *= generator.uniform(0.2, 1.0, (dof, 1))
    max_usage = generator.uniform(*START_USAGE)
    constant = np.concatenate([centre, np.zeros(waves.size)])
    oscillating = np.concatenate([np.zeros(dof), waves.ravel()])
    sizes = np.geomspace(1e-3, 10, 60)
    fitting = bisect_left(
        sizes, True, key=lambda size: problem.usage((constant + size * oscillating)[None]).max() > max_usage
    )
    return constant + sizes[fitting - 1] * oscillating if fitting else None


def _centres(rig: Rig, generator: Generator) -> Iterator[Floats]:
    """Yield at most RANDOM_STARTS joint positions (dof,): the middle of the allowed range, and others around it."""
    yield _middle(rig)
    for offset in generator.uniform(-CENTRE_OFFSET, CENTRE_OFFSET, (RANDOM_STARTS - 1, rig.dof)):
        with suppress(kinematics.Unreachable):
            yield _middle(rig, offset)


def _middle(rig: Rig, offset: Floats | None = None) -> Floats:
    """Joint positions (dof,) in the middle of the allowed range, plus `offset` (dof,) relative to half the range."""
    limits, offset = rig.limits, np.zeros(rig.dof) if offset is None else offset
    if rig.mechanism == "delta":
        low, high = limits.workspace_z
        reach = np.array([limits.workspace_radius, limits.workspace_radius, (high - low) / 2])
        position = np.array([0.0, 0.0, (low + high) / 2]) + offset * reach
        return kinematics.inverse(rig.geometry, position[None])[0]
    low, high = limits.joint_min, limits.joint_max
    return (low + high) / 2 + offset * (high - low) / 2


def _optimized(problem: DesignProblem, start: Floats, iterations: int, callback: Callable[[], None]) -> Floats:
    """Return the best coefficients (v,) within the limits that the search from `start` (v,) evaluated."""
    from scipy.optimize import NonlinearConstraint, minimize

    slopes = _cached(problem.slopes)
    best = [start]
    least = [_objective(problem, start)]

    def evaluate(x: Floats) -> tuple[Floats, Floats]:
        value, used = problem.evaluate(x[None])
        if value[0] < least[0] and used.max() <= MARGIN + SLACK:
            best[0], least[0] = x.copy(), float(value[0])
        return value, used

    def objective(x: Floats) -> float:
        return OBJECTIVE_SCALE * float(values(x)[0][0])

    def slope(x: Floats) -> Floats:
        return OBJECTIVE_SCALE * slopes(x)[0]

    values = _cached(evaluate)
    limits = NonlinearConstraint(lambda x: values(x)[1][0], -np.inf, MARGIN, jac=lambda x: slopes(x)[1])
    minimize(
        objective,
        start,
        jac=slope,
        method="SLSQP",
        constraints=limits,
        options={"maxiter": iterations},
        callback=lambda _: callback(),
    )
    return best[0]


def _cached(function: Callable[[Floats], tuple[Floats, Floats]]) -> Callable[[Floats], tuple[Floats, Floats]]:
    """Cache the last result of `function`, which is called for the objective and then for the limits."""
    at: list[Floats] = []
    result: list[tuple[Floats, Floats]] = []

    def cached(x: Floats) -> tuple[Floats, Floats]:
        if not at or not np.array_equal(at[0], x):
            at[:], result[:] = [x.copy()], [function(x)]
        return result[0]

    return cached


def _within_limits(series: FourierSeries, rig: Rig) -> FourierSeries:
    """Scale `series` about its centre until start, end and the motion between the samples are within the limits."""
    for size in np.linspace(1.0, 0.0, 101):
        scaled = series.model_copy(update={name: _scaled(getattr(series, name), size) for name in ("cosine", "sine")})
        used = checks.usage(assemble(scaled.motion("design"), rig, cycles=1), rig)
        if max(values.max() for values in used.values()) <= MARGIN:
            break
    return scaled


def _scaled(axes: tuple[tuple[float, ...], ...], size: float) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(size) * value for value in axis) for axis in axes)
