import numba
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.estimation.l1_objective import L1Objective
from recordings.recording import Floats


def problem(m: int, k: int, n: int) -> tuple[Floats, Floats, Floats]:
    rng = np.random.default_rng(m)
    return rng.normal(size=(m, k)), rng.normal(size=m), rng.normal(size=(n, k))


@settings(deadline=None)
@given(m=st.integers(1, 200), n=st.integers(1, 70))
def test_objective_is_the_sum_of_absolute_residuals(m: int, n: int) -> None:
    regressor, torque, particles = problem(m, 11, n)
    expected = np.abs(torque - particles @ regressor.T).sum(axis=1)
    np.testing.assert_allclose(L1Objective(regressor, torque)(particles), expected, rtol=1e-12)


def test_result_does_not_depend_on_threads_or_other_particles() -> None:
    regressor, torque, particles = problem(20_000, 11, 300)
    objective = L1Objective(regressor, torque)
    all_at_once = objective(particles)
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        np.testing.assert_array_equal(objective(particles), all_at_once)
    finally:
        numba.set_num_threads(threads)
    one_by_one = np.concatenate([objective(particle[None]) for particle in particles[:20]])
    np.testing.assert_array_equal(one_by_one, all_at_once[:20])
