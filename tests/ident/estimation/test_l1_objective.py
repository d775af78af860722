import numba
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.estimation import l1_objective
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
    assert len(torque) * len(particles) > l1_objective._MIN_PARALLEL_WORK
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


def test_objective_works_without_a_cache(monkeypatch: pytest.MonkeyPatch) -> None:
    compile_ = numba.njit

    def njit_without_cache(*, cache: bool = False, **options: object) -> object:
        if cache:
            raise RuntimeError("cannot cache function: no locator available")
        return compile_(**options)

    monkeypatch.setattr(numba, "njit", njit_without_cache)
    l1_objective._kernel.cache_clear()
    regressor, torque, particles = problem(10, 3, 4)
    expected = np.abs(torque - particles @ regressor.T).sum(axis=1)
    np.testing.assert_allclose(L1Objective(regressor, torque)(particles), expected)
    l1_objective._kernel.cache_clear()
