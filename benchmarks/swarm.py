"""Compare the particle swarm with other libraries: same data, same settings, same objective."""

import logging
import tempfile
import timeit
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.certificate import problem
from benchmarks.programs import claim, record_demo, timed
from ident.estimation.estimators import pso
from ident.estimation.l1_objective import L1Objective
from ident.estimation.lad_certificate import Certificate, certify
from ident.estimation.problem import Problem
from recordings.recording import Floats

SETTINGS = pso.Settings(tolerance=0.0)
"""Settings of the paper: 300 particles, 60 neighbours, 1000 iterations."""
LIMIT = 1.5e-3
"""Arithmetic limit of two cores for one evaluation of 300 particles on 30,000 rows of 11 columns [s]."""
SEED = 0

Search = Callable[[Problem], float]
"""Returns the best objective."""


def ours(given: Problem) -> float:
    """Run the swarm of `ident fit --paper`."""
    return pso.estimate(given, np.random.default_rng(SEED), lambda *_: None, SETTINGS).objective


def ours_until_certified(given: Problem) -> float:
    """Run the swarm of `ident fit`, which stops at the certified minimum."""
    return pso.estimate(given, np.random.default_rng(SEED), lambda *_: None, pso.Settings()).objective


def pyswarms(given: Problem) -> float:
    """Run LocalBestPSO with static neighbours, as in this project."""
    from pyswarms.single import LocalBestPSO

    logging.disable(logging.INFO)
    np.random.seed(SEED)  # noqa: NPY002  the library draws from numpy's global generator
    options = {
        "c1": SETTINGS.cognitive,
        "c2": SETTINGS.social,
        "w": SETTINGS.inertia,
        "k": SETTINGS.neighbours,
        "p": 2,
    }
    swarm = LocalBestPSO(
        SETTINGS.particles,
        len(given.bounds),
        options,
        bounds=tuple(given.bounds.T),
        bh_strategy="nearest",
        static=True,
    )
    best, _ = swarm.optimize(numpy_objective(given), SETTINGS.iterations, verbose=False)
    return float(best)


def pymoo(given: Problem) -> float:
    """Run PSO with constant coefficients; it has no neighbourhoods."""
    from pymoo.algorithms.soo.nonconvex.pso import PSO
    from pymoo.core.problem import Problem as PymooProblem
    from pymoo.optimize import minimize

    objective = numpy_objective(given)

    class Objective(PymooProblem):  # type: ignore[misc]
        def _evaluate(self, x: Floats, out: dict[str, Any], *args: Any, **kwargs: Any) -> None:
            out["F"] = objective(x)

    lowest, highest = given.bounds.T
    algorithm = PSO(
        pop_size=SETTINGS.particles,
        w=SETTINGS.inertia,
        c1=SETTINGS.cognitive,
        c2=SETTINGS.social,
        adaptive=False,
        pertube_best=False,
    )
    pymoo_problem = Objective(n_var=len(lowest), n_obj=1, xl=lowest, xu=highest)
    result = minimize(pymoo_problem, algorithm, ("n_gen", SETTINGS.iterations + 1), seed=SEED)
    return float(result.F[0])


def numpy_objective(given: Problem) -> Callable[[Floats], Floats]:
    """Return Eq. (33) as a numpy function of all particles (n, k)."""
    transposed = np.ascontiguousarray(given.regressor.T)

    def objective(particles: Floats) -> Floats:
        return np.abs(given.torque - particles @ transposed).sum(axis=1)

    return objective


def main() -> None:
    """Print times, ratios, and final objectives above the certified minimum."""
    with tempfile.TemporaryDirectory() as folder:
        given = problem(record_demo(Path(folder), "fig5a")[0], "central")
    certificate = certify(given.regressor, given.torque, given.bounds)
    _compare_evaluations(given)
    searches: dict[str, Search] = {
        "ours": ours,
        "ours, until certified": ours_until_certified,
        "pyswarms LocalBestPSO": pyswarms,
        "pymoo PSO": pymoo,
    }
    print(
        f"swarm: {SETTINGS.particles} particles, {SETTINGS.neighbours} neighbours, {SETTINGS.iterations} iterations, "
        f"{len(given.torque)} rows"
    )
    measured: dict[str, float] = {}
    for name, search in searches.items():
        measured[name], line = _measure(search, given, certificate)
        times = measured[name] / measured["ours"]
        print(f"  {name:22} {measured[name]:7.2f} s  {times:6.1f} times ours  {line}", flush=True)
    others = [seconds for name, seconds in measured.items() if not name.startswith("ours") and seconds]
    claim("the swarm is faster than those of other libraries", measured["ours"] < min(others, default=np.inf))


def _measure(search: Search, given: Problem, certificate: Certificate) -> tuple[float, str]:
    try:
        objective, seconds = timed(lambda: search(given))
    except ModuleNotFoundError as error:
        return 0.0, f"not measured: {error}; install the extra `bench`"
    return seconds, f"ended {certificate.excess(objective):.1e} above the certified minimum"


def _compare_evaluations(given: Problem) -> None:
    """Time one evaluation of the whole swarm by the compiled kernel and by numpy."""
    lowest, highest = given.bounds.T
    particles = np.random.default_rng(SEED).uniform(lowest, highest, (SETTINGS.particles, len(lowest)))
    kernel, numpy_function = L1Objective(given.regressor, given.torque), numpy_objective(given)
    np.testing.assert_allclose(kernel(particles), numpy_function(particles), rtol=1e-10)
    kernel_time, numpy_time = (
        min(timeit.repeat(lambda: kernel(particles), number=1, repeat=50)),
        min(timeit.repeat(lambda: numpy_function(particles), number=1, repeat=5)),
    )
    print(
        f"evaluation: ours {1e3 * kernel_time:.2f} ms, {kernel_time / LIMIT:.1f} of the arithmetic limit "
        f"({1e3 * LIMIT:g} ms); numpy {1e3 * numpy_time:.1f} ms, {numpy_time / kernel_time:.0f} times ours"
    )


if __name__ == "__main__":
    main()
