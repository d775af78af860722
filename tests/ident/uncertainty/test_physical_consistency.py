"""Physically impossible parameters, and the coupling of joints by the inertia matrix."""

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.mechanisms import Parameter
from ident.uncertainty.physical_consistency import coupling, inertia_matrix, violations
from tests.ident import building
from tests.ident.conftest import TRUTH, make_recording

MASS = Parameter("m", "kg", "a mass", nonnegative=True)
FRICTION = Parameter("c", "N m", "friction", friction=True)
OFFSET = Parameter("a", "N m", "an offset")


def test_only_negative_masses_and_friction_are_impossible() -> None:
    values = np.array([-1.0, -2.0, -3.0])
    intervals = values[:, None] + [-0.5, 0.5]
    mass, friction = violations((MASS, FRICTION, OFFSET), values, intervals)
    assert (mass.name, mass.significant) == ("m", True)
    assert "must be positive for any body" in mass.sentence
    assert "friction would drive the motion" in friction.sentence
    assert violations((MASS, FRICTION, OFFSET), np.zeros(3), intervals) == ()


@pytest.mark.parametrize("highest", [0.2, np.nan])
def test_negative_value_may_be_chance_if_its_interval_is_unknown_or_reaches_zero(highest: float) -> None:
    (violation,) = violations((MASS,), np.array([-1.0]), np.array([[-2.2, highest]]))
    assert not violation.significant
    assert "this may be chance" in violation.sentence


def test_inertia_matrix_of_independent_axes_is_the_diagonal_of_their_inertias() -> None:
    motion = building.motion_of(joints=3)
    values = np.array([0.1, 0.2, 0.3, *np.ones(6)])
    mechanism = mechanisms.create(building.bench(3))
    D = inertia_matrix(mechanism.regressor, motion.position[:5], values)
    np.testing.assert_allclose(D, np.tile(np.diag([0.1, 0.2, 0.3]), (5, 1, 1)), atol=1e-15)
    result = coupling(mechanism.regressor, motion, values)
    assert result is not None
    np.testing.assert_allclose(result.off_diagonal, np.eye(3), atol=1e-12)
    assert result.share == pytest.approx(0.0, abs=1e-12)
    assert result.positive


def test_negative_inertia_is_not_positive_definite() -> None:
    values = np.array([0.1, -0.2, *np.ones(4)])
    result = coupling(mechanisms.create(building.bench(2)).regressor, building.motion_of(2), values)
    assert result is not None
    assert not result.positive


def test_single_joint_has_no_coupling() -> None:
    assert (
        coupling(mechanisms.create(building.bench()).regressor, building.motion_of(), building.parameters()) is None
    )


def test_inertia_matrix_of_the_delta_robot_is_symmetric_positive_and_coupled() -> None:
    recording = make_recording(cycles=1, rate=100.0)
    mechanism = mechanisms.create(recording.rig)
    D = inertia_matrix(mechanism.regressor, recording.position[::20], TRUTH)
    np.testing.assert_allclose(D, D.swapaxes(1, 2), atol=1e-9)
    assert (np.linalg.eigvalsh(D) > 0).all()
