"""The search for the best excitation: sequential quadratic programming from several random starts."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import count

import numpy as np
from numpy.random import Generator

from ident.design.problem import Criterion, Problem
from ident.estimators import Progress
from ident.mechanisms import Mechanism
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import checks, kinematics
from trajectories.fourier import FourierSeries
from trajectories.trajectory import assemble

STARTS = 3
"""Random starts, of which the best result is kept."""
ITERATIONS = 80
"""Of each start, at most."""
MARGIN = 0.95
"""Share of each limit that is used at most."""
STARTING = 0.5
"""Share of the limits that is used at the start."""


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
    problem = Problem(rig, mechanism, criterion, period, harmonics, np.ones(len(mechanism.parameters)))
    starts = [_start(problem, generator) for _ in range(STARTS)]
    problem = replace(problem, scale=np.maximum(problem.sizes(starts[0]), 1e-9))
    found = []
    for number, start in enumerate(starts):
        progress(number * ITERATIONS, STARTS * ITERATIONS)
        found.append(_improved(problem, start, partial(_report, progress, number)))
    best = min(found, key=lambda one: float(problem.evaluate(one[None])[0][0]))
    return _within_limits(problem.series(best), rig)


def _report(progress: Progress, number: int, step: int) -> None:
    progress(number * ITERATIONS + step, STARTS * ITERATIONS)


def _start(problem: Problem, generator: Generator) -> Floats:
    """Random coefficients (v,), of equal speed in all harmonics, that use STARTING of the limits."""
    dof, harmonics = problem.rig.dof, problem.harmonics
    waves = generator.normal(size=(2, dof, harmonics)) / np.arange(1, harmonics + 1)
    still = np.concatenate([_centre(problem.rig), np.zeros(waves.size)])
    moving = np.concatenate([np.zeros(dof), waves.ravel()])
    sizes = np.geomspace(1e-3, 10, 60)
    used = [problem.evaluate((still + size * moving)[None])[1].max() for size in sizes]
    fitting = [size for size, most in zip(sizes, used, strict=True) if most <= STARTING]
    if not fitting:
        raise BadInput(
            f"rig '{problem.rig.name}': limits that leave room to move around the joint positions "
            f"{np.round(_centre(problem.rig), 3).tolist()} expected, none found; check the limits in the rig file"
        )
    start: Floats = still + fitting[-1] * moving
    return start


def _centre(rig: Rig) -> Floats:
    """Joint positions (dof,) in the middle of what is allowed."""
    limits = rig.limits
    if rig.mechanism == "delta":
        middle: Floats = kinematics.inverse(rig.geometry, np.array([[0.0, 0.0, np.mean(limits.workspace_z)]]))[0]
        return middle
    return np.full(rig.dof, (limits.joint_min + limits.joint_max) / 2)


def _improved(problem: Problem, start: Floats, report: Callable[[int], None]) -> Floats:
    """The coefficients (v,) that the search ends with from `start` (v,)."""
    from scipy.optimize import NonlinearConstraint, minimize

    steps = count(1)
    values = _remembered(lambda x: problem.evaluate(x[None]))
    slopes = _remembered(problem.slopes)

    def objective(x: Floats) -> float:
        return float(values(x)[0][0])

    def slope(x: Floats) -> Floats:
        return slopes(x)[0]

    limits = NonlinearConstraint(lambda x: values(x)[1][0], -np.inf, MARGIN, jac=lambda x: slopes(x)[1])
    result = minimize(
        objective,
        start,
        jac=slope,
        method="SLSQP",
        constraints=limits,
        options={"maxiter": ITERATIONS},
        callback=lambda _: report(next(steps)),
    )
    return np.asarray(result.x, dtype=np.float64)


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
