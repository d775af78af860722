"""The variables on which an unexplained residual depends."""

import numpy as np
import pytest

from ident.diagnosis.unknown.residual_dependence import ResidualDependence, find_dependences
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

Torque = building.Torque


def dependences(torque: Torque, noise: float = 0.02, joints: int = 2) -> list[ResidualDependence]:
    data = building.split([building.record(joints, 6, noise=noise, extra=torque)])
    model = building.fitted(data)
    return find_dependences(data, model.solution, model.residuals, range(joints))


def on_joint_1(torque: Floats) -> Floats:
    """Of two joints."""
    only = np.zeros_like(torque)
    only[:, 0] = torque[:, 0]
    return only


CAUSES: list[tuple[Torque, tuple[str, ...]]] = [
    (lambda motion: on_joint_1(np.cos(3 * motion.position)), ("position",)),
    (lambda motion: on_joint_1(np.exp(-((motion.velocity / 1.2) ** 2)) * motion.direction), ("velocity",)),
    (lambda motion: on_joint_1(np.abs(motion.acceleration) * 0.1), ("acceleration",)),
    (lambda motion: on_joint_1(motion.direction * np.cos(3 * motion.position)), ("position", "velocity")),
    (lambda motion: on_joint_1(np.abs(motion.velocity[:, ::-1])), ("velocity", "joint_2")),
]


@pytest.mark.parametrize(("torque", "variables"), CAUSES, ids=["-".join(names) for _, names in CAUSES])
def test_planted_variable_is_found_with_its_share(torque: Torque, variables: tuple[str, ...]) -> None:
    (dependence,) = dependences(torque)
    assert dependence.joint == 0
    assert dependence.variables == variables
    assert dependence.explained > 0.4


def test_drift_depends_on_time() -> None:
    def drift(motion: Motion) -> Floats:
        return on_joint_1(np.linspace(-1, 1, len(motion.position))[:, None] * np.ones(2))

    (dependence,) = dependences(drift)
    assert dependence.variables == ("time",)


def test_noise_depends_on_nothing() -> None:
    assert dependences(lambda motion: np.zeros_like(motion.position), noise=0.3) == []


def test_residual_that_the_model_explains_has_no_dependence() -> None:
    """A viscous torque is a parameter of the mechanism."""
    assert dependences(lambda motion: 3.0 * motion.velocity, noise=0.3) == []


def test_explained_share_of_a_partly_noisy_residual() -> None:
    """Noise and curve of about equal power: about half of the test residual is explained."""
    noise = np.sqrt(0.5 * building.RATE / (2 * building.CUTOFF))
    (dependence,) = dependences(lambda motion: np.cos(5 * motion.position), noise=noise, joints=1)
    assert 0.2 < dependence.explained < 0.75
