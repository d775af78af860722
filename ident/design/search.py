"""The search for the best excitation: sequential quadratic programming from several random starts."""

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
"""Random motions that are looked at."""
SHORT_RUNS = 8
"""The best of them are improved a little,"""
SHORT_ITERATIONS = 25
"""by so many iterations;"""
LONG_RUNS = 3
"""the best of these"""
LONG_ITERATIONS = 120
"""by so many more, and the best result is kept."""
TOTAL_ITERATIONS = SHORT_RUNS * SHORT_ITERATIONS + LONG_RUNS * LONG_ITERATIONS
"""Iterations in all, at most."""
OBJECTIVE_SCALE = 0.03
"""Factor of the objective: the first steps of a search are as long as its slope, and are not to lead far astray."""
MARGIN = 0.95
"""Share of each limit that is used at most."""
SLACK = 0.005
"""What the search may be beyond that: the result is made smaller in the end."""
START_USAGE = (0.3, 0.9)
"""Share of the limits that is used at the start, from and to."""
HARMONIC_DECAY = (1.0, 3.0)
"""Power of its number with which a harmonic is smaller at the start, from and to: of equal speed, or hardly there."""
CENTRE_OFFSET = 0.5
"""A start's centre may lie beside the middle by so much, over half of what is allowed [of the joints' range]."""


def search(
    rig: Rig,
    mechanism: Mechanism,
    criterion: Criterion,
    period: float,
    harmonics: int,
    generator: Generator,
    progress: Progress,
) -> FourierSeries:
    """The best motion found, a Fourier series of `harmonics` with the `period` [s] in every joint.

    Raises:
        BadInput: there is no motion within the limits.
    """
    problem = DesignProblem(rig, mechanism, criterion, period, harmonics, np.ones(len(mechanism.parameters)))
    starts = _starts(problem, generator)
    if criterion != "t":  # which has strengths of its own
        problem = replace(problem, scale=np.maximum(problem.column_sizes(starts[0]), 1e-9))
    steps = count(1)
    for kept, iterations in ((SHORT_RUNS, SHORT_ITERATIONS), (LONG_RUNS, LONG_ITERATIONS)):
        starts = sorted(starts, key=partial(_objective, problem))[:kept]
        starts = [_improved(problem, start, iterations, lambda: progress(next(steps), TOTAL_ITERATIONS)) for start in starts]
    return _within_limits(problem.series(min(starts, key=partial(_objective, problem))), rig)


def random_motion(rig: Rig, mechanism: Mechanism, period: float, harmonics: int, generator: Generator) -> FourierSeries:
    """A random motion of the same kind.

    Raises:
        BadInput: there is no motion within the limits.
    """
    problem = DesignProblem(rig, mechanism, "d", period, harmonics, np.ones(len(mechanism.parameters)))
    return _within_limits(problem.series(_starts(problem, generator)[0]), rig)


def _objective(problem: DesignProblem, coefficients: Floats) -> float:
    return float(problem.evaluate(coefficients[None])[0][0])


def _starts(problem: DesignProblem, generator: Generator) -> list[Floats]:
    """DRAWN random motions (v,), or fewer where there is no room around all of the centres.

    Raises:
        BadInput: there is none.
    """
    starts = [_start(problem, centre, generator) for centre in _centres(problem.rig, generator)]
    found = [start for start in starts if start is not None]
    if not found:
        raise BadInput(
            f"rig '{problem.rig.name}': limits that leave room to move around the joint positions "
            f"{np.round(_middle(problem.rig), 3).tolist()} expected, none found; check the limits in the rig file"
        )
    return found


def _start(problem: DesignProblem, centre: Floats, generator: Generator) -> Floats | None:
    """Random coefficients (v,) around joint positions (dof,); None without room."""
    dof, harmonics = problem.rig.dof, problem.harmonics
    falling = generator.uniform(*HARMONIC_DECAY)
    waves = generator.normal(size=(2, dof, harmonics)) / np.arange(1, harmonics + 1) ** falling
    waves *= generator.uniform(0.2, 1.0, (dof, 1))
    most = generator.uniform(*START_USAGE)
    still = np.concatenate([centre, np.zeros(waves.size)])
    moving = np.concatenate([np.zeros(dof), waves.ravel()])
    sizes = np.geomspace(1e-3, 10, 60)
    fitting = bisect_left(sizes, True, key=lambda size: problem.usage((still + size * moving)[None]).max() > most)
    return still + sizes[fitting - 1] * moving if fitting else None


def _centres(rig: Rig, generator: Generator) -> Iterator[Floats]:
    """DRAWN joint positions (dof,) at most: the middle of what is allowed, and others beside it."""
    yield _middle(rig)
    for aside in generator.uniform(-CENTRE_OFFSET, CENTRE_OFFSET, (RANDOM_STARTS - 1, rig.dof)):
        with suppress(kinematics.Unreachable):
            yield _middle(rig, aside)


def _middle(rig: Rig, aside: Floats | None = None) -> Floats:
    """Joint positions (dof,) in the middle of what is allowed, or `aside` (dof,) of it, 1 being the limit."""
    limits, aside = rig.limits, np.zeros(rig.dof) if aside is None else aside
    if rig.mechanism == "delta":
        low, high = limits.workspace_z
        reach = np.array([limits.workspace_radius, limits.workspace_radius, (high - low) / 2])
        place = np.array([0.0, 0.0, (low + high) / 2]) + aside * reach
        middle: Floats = kinematics.inverse(rig.geometry, place[None])[0]
        return middle
    low, high = limits.joint_min, limits.joint_max
    return (low + high) / 2 + aside * (high - low) / 2


def _improved(problem: DesignProblem, start: Floats, iterations: int, report: Callable[[], None]) -> Floats:
    """The best coefficients (v,) within the limits that the search has seen from `start` (v,)."""
    from scipy.optimize import NonlinearConstraint, minimize

    slopes = _remembered(problem.slopes)
    best = [start]
    least = [_objective(problem, start)]

    def looked_at(x: Floats) -> tuple[Floats, Floats]:
        value, used = problem.evaluate(x[None])
        if value[0] < least[0] and used.max() <= MARGIN + SLACK:
            best[0], least[0] = x.copy(), float(value[0])
        return value, used

    def objective(x: Floats) -> float:
        return OBJECTIVE_SCALE * float(values(x)[0][0])

    def slope(x: Floats) -> Floats:
        return OBJECTIVE_SCALE * slopes(x)[0]

    values = _remembered(looked_at)
    limits = NonlinearConstraint(lambda x: values(x)[1][0], -np.inf, MARGIN, jac=lambda x: slopes(x)[1])
    minimize(
        objective,
        start,
        jac=slope,
        method="SLSQP",
        constraints=limits,
        options={"maxiter": iterations},
        callback=lambda _: report(),
    )
    return best[0]


def _remembered(function: Callable[[Floats], tuple[Floats, Floats]]) -> Callable[[Floats], tuple[Floats, Floats]]:
    """`function`, computed once where it is asked twice in a row: for the objective, then for the limits."""
    at: list[Floats] = []
    result: list[tuple[Floats, Floats]] = []

    def evaluated(x: Floats) -> tuple[Floats, Floats]:
        if not at or not np.array_equal(at[0], x):
            at[:], result[:] = [x.copy()], [function(x)]
        return result[0]

    return evaluated


def _within_limits(series: FourierSeries, rig: Rig) -> FourierSeries:
    """`series`, made smaller about its centre where start, end, or what is between the samples need it."""
    for size in np.linspace(1.0, 0.0, 101):
        smaller = series.model_copy(update={name: _times(getattr(series, name), size) for name in ("cosine", "sine")})
        used = checks.usage(assemble(smaller.motion("design"), rig, cycles=1), rig)
        if max(values.max() for values in used.values()) <= MARGIN:
            break
    return smaller


def _times(axes: tuple[tuple[float, ...], ...], size: float) -> tuple[tuple[float, ...], ...]:
    return tuple(tuple(float(size) * value for value in axis) for axis in axes)
