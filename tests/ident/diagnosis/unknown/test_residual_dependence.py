"""The variables on which an unexplained residual depends, and curves that are fitted to it."""

import numpy as np
import pytest

from ident.diagnosis.unknown.residual_dependence import (
    NonparametricFit,
    ResidualDependence,
    find_dependences,
    fit_curves,
)
from ident.diagnosis.unknown.residual_test import estimate_unexplained
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

FIRST = np.array([1.0, 0.0])
"""The first of two joints alone."""


def dependences(torque: building.Torque, noise: float = 0.02, joints: int = 2) -> list[ResidualDependence]:
    data = building.split([building.record(joints, 6, noise=noise, extra=torque)])
    model = building.fitted(data)
    return find_dependences(data, model.solution, model.residuals, range(joints))


def drift(motion: Motion) -> Floats:
    return np.linspace(-1, 1, len(motion.position))[:, None] * np.ones(2)


CAUSES: list[tuple[building.Torque, tuple[str, ...]]] = [
    (lambda motion: np.cos(3 * motion.position), ("position",)),
    (lambda motion: np.exp(-((motion.velocity / 1.2) ** 2)) * motion.direction, ("velocity",)),
    (lambda motion: np.abs(motion.acceleration) * 0.1, ("acceleration",)),
    (lambda motion: motion.direction * np.cos(3 * motion.position), ("position", "velocity")),
    (lambda motion: np.abs(motion.velocity[:, ::-1]), ("velocity", "joint_2")),
    (drift, ("time",)),
]


@pytest.mark.parametrize(("torque", "variables"), CAUSES, ids=["-".join(names) for _, names in CAUSES])
def test_planted_variable_is_found_with_its_share(torque: building.Torque, variables: tuple[str, ...]) -> None:
    (dependence,) = dependences(lambda motion: torque(motion) * FIRST)
    assert (dependence.joint, dependence.variables) == (0, variables)
    assert dependence.explained > 0.4


@pytest.mark.parametrize("viscous", [0.0, 3.0])
def test_noise_and_what_the_mechanism_explains_depend_on_nothing(viscous: float) -> None:
    assert dependences(lambda motion: viscous * motion.velocity, noise=0.3) == []


def test_explained_share_of_a_partly_noisy_residual() -> None:
    """Noise and curve of about equal power: about half of the test residual is explained."""
    noise = np.sqrt(0.5 * building.RATE / (2 * building.CUTOFF))
    (dependence,) = dependences(lambda motion: np.cos(5 * motion.position), noise=noise, joints=1)
    assert 0.2 < dependence.explained < 0.75


def curves(extra: building.Torque) -> NonparametricFit:
    model = building.fitted(building.split([building.record(2, noise=0.02, extra=extra)]))
    result = fit_curves(model, estimate_unexplained(model).dependences)
    assert result.improvement.is_supported
    return result


@pytest.mark.parametrize(
    ("torque", "variable"), [(lambda motion: np.sin(1.5 * motion.velocity), "velocity"), (drift, "time")]
)
def test_curve_is_the_planted_one_up_to_the_model(torque: building.Torque, variable: str) -> None:
    """Coulomb and viscous friction of the model may take a part of it: the sum is that of the plant."""
    result = curves(lambda motion: torque(motion) * FIRST)
    assert [(curve.joint, curve.variable) for curve in result.curves] == [(1, variable)]
    assert result.improvement.share > 0.95
    (residual,) = result.model.residuals
    assert np.nanstd(residual[result.model.split.scored[0][:, 0], 0]) < 0.1


@pytest.mark.parametrize(("size", "joints"), [(0.1, {1}), (0.6, {1, 2})])
def test_residual_that_is_small_beside_the_largest_gets_no_curve(size: float, joints: set[int]) -> None:
    result = curves(lambda motion: np.sin(1.5 * motion.velocity) * [1.0, size])
    assert {curve.joint for curve in result.curves} == joints
