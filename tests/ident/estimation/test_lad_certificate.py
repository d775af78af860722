from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.estimation.lad_certificate import Certificate, certify
from recordings.recording import Floats

LinearProgram = Callable[[Floats, Floats, Floats], tuple[Floats, float]]
WIDE = np.tile([-100.0, 100.0], (5, 1))


def problem(m: int = 500, k: int = 5, seed: int = 0) -> tuple[Floats, Floats]:
    """Columns whose sizes differ by up to 1e4, and a torque with noise of heavy tails."""
    rng = np.random.default_rng(seed)
    regressor = rng.normal(size=(m, k)) * np.geomspace(0.01, 100, k)
    return regressor, regressor @ rng.normal(size=k) + rng.standard_t(2, size=m)


def objective(regressor: Floats, torque: Floats, parameters: Floats) -> float:
    return float(np.abs(torque - regressor @ parameters).sum())


def exact(certificate: Certificate) -> bool:
    return 0 < certificate.lower_bound <= certificate.objective <= certificate.lower_bound * (1 + 1e-10)


@pytest.mark.parametrize("seed", range(5))
def test_minimum_equals_the_optimum_of_the_linear_program(
    seed: int, least_absolute_deviations: LinearProgram
) -> None:
    regressor, torque = problem(seed=seed)
    certificate = certify(regressor, torque, WIDE)
    parameters, minimum = least_absolute_deviations(regressor, torque, WIDE)
    assert exact(certificate)
    assert certificate.objective == pytest.approx(minimum, rel=1e-10)
    assert certificate.objective == pytest.approx(objective(regressor, torque, certificate.parameters), rel=1e-14)
    np.testing.assert_allclose(certificate.parameters, parameters, rtol=1e-6)


def test_minimum_within_the_search_region_equals_the_optimum_of_the_linear_program(
    least_absolute_deviations: LinearProgram,
) -> None:
    regressor, torque = problem()
    unconstrained = certify(regressor, torque, WIDE).parameters
    bounds = np.stack([unconstrained - 3, unconstrained + 3], axis=1)
    bounds[1], bounds[3] = unconstrained[1] + [0.1, 4], unconstrained[3] - [4, 0.001]
    certificate = certify(regressor, torque, bounds)
    parameters, minimum = least_absolute_deviations(regressor, torque, bounds)
    assert exact(certificate)
    assert certificate.objective == pytest.approx(minimum, rel=1e-10)
    np.testing.assert_allclose(certificate.parameters, parameters, rtol=1e-5)
    assert ((bounds[:, 0] <= certificate.parameters) & (certificate.parameters <= bounds[:, 1])).all()


@settings(deadline=None, max_examples=40)
@given(
    m=st.integers(1, 60),
    k=st.integers(1, 6),
    seed=st.integers(0, 10**6),
    quantised=st.booleans(),
    width=st.sampled_from([0.1, 1.0, 1e3]),
)
def test_no_objective_in_the_region_is_below_the_bound(
    m: int, k: int, seed: int, quantised: bool, width: float
) -> None:
    rng = np.random.default_rng(seed)
    regressor, torque = rng.normal(size=(m, k)), rng.normal(size=m)
    if quantised:  # many equal rows and residuals
        regressor, torque = np.round(regressor), np.round(torque)
    bounds = np.sort(rng.uniform(-width, width, (k, 2)), axis=1)
    certificate = certify(regressor, torque, bounds)
    assert ((bounds[:, 0] <= certificate.parameters) & (certificate.parameters <= bounds[:, 1])).all()
    assert certificate.objective >= certificate.lower_bound
    for parameters in [*rng.uniform(*bounds.T, (30, k)), certificate.parameters]:
        assert objective(regressor, torque, parameters) >= certificate.lower_bound * (1 - 1e-13)


def degenerate(kind: str) -> tuple[Floats, Floats]:
    regressor, torque = problem()
    match kind:
        case "equal columns":
            regressor[:, 1] = regressor[:, 0]
        case "column of zeros":
            regressor[:, 2] = 0
        case "standstill":
            regressor[300:], torque[300:] = regressor[300], torque[300]
        case "quantised":
            regressor, torque = np.round(regressor), np.round(torque)
        case "outliers":  # a tenth of the rows is wrong by any amount
            torque[::10] *= 1e6
    return regressor, torque


@pytest.mark.parametrize("kind", ["equal columns", "column of zeros", "standstill", "quantised", "outliers"])
def test_degenerate_data_have_the_exact_minimum(kind: str, least_absolute_deviations: LinearProgram) -> None:
    regressor, torque = degenerate(kind)
    certificate = certify(regressor, torque, WIDE)
    _, minimum = least_absolute_deviations(regressor, torque, WIDE)
    assert certificate.objective == pytest.approx(minimum, rel=1e-8)
    assert certificate.lower_bound == pytest.approx(minimum, rel=1e-5)


def test_the_excess_of_a_perfect_fit_is_relative_to_the_torque() -> None:
    regressor, _ = problem()
    truth = np.arange(1.0, 6.0)
    torque = regressor @ truth
    certificate = certify(regressor, torque, WIDE)
    np.testing.assert_allclose(certificate.parameters, truth, rtol=1e-9)
    assert certificate.excess(certificate.objective) < 1e-3
    assert certificate.excess(1e-9 * np.abs(torque).sum()) == pytest.approx(1, rel=1e-3)


def test_the_excess_is_relative_finite_and_never_negative() -> None:
    certificate = Certificate(np.zeros(1), 100.0, 100.0, 100.0)
    assert certificate.excess(101.0) == pytest.approx(0.01)
    assert certificate.excess(100.0 - 1e-12) == 0
    still = certify(problem()[0], np.zeros(500), WIDE)
    assert still.objective == pytest.approx(0, abs=1e-9)
    assert np.isfinite(still.excess(1.0))
