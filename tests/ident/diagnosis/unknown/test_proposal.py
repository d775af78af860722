"""Formulas for what is in no library: the law that was planted is found, and nothing where nothing is left."""

import numpy as np
import pytest

from ident.diagnosis.unknown.proposal import Proposal, propose
from ident.diagnosis.unknown.residual_test import estimate_unexplained
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


def uneven_grease(motion: Motion) -> Floats:
    torque: Floats = 0.3 * np.sin(3 * motion.position + 0.5) * motion.velocity
    return torque


def eddy_currents(motion: Motion) -> Floats:
    torque: Floats = 2.0 * motion.velocity / (1 + (motion.velocity / 0.7) ** 2)
    return torque


def cable(motion: Motion) -> Floats:
    """Between two joints."""
    pull = 2.0 * (motion.position[:, :1] - motion.position[:, 1:])
    return np.concatenate([pull, -pull], axis=1)


def proposal(torque: building.Torque, joints: int = 1) -> Proposal | None:
    """The formula for what the mechanism alone leaves."""
    train, held_out = (building.record(joints, noise=0.05, extra=torque, shape=shape, seed=shape) for shape in (0, 1))
    model = building.fitted(building.split([train], [held_out]))
    return propose(model, estimate_unexplained(model))


@pytest.mark.parametrize(
    ("torque", "joints", "column", "value"),
    [
        (uneven_grease, 1, "qd * sin(3 * q)", 0.3 * np.cos(0.5)),
        pytest.param(eddy_currents, 1, "qd / (1 + (qd / v) ** 2)", 2.0, marks=pytest.mark.slow),
        pytest.param(cable, 2, "(q1 - q2)", 2.0, marks=pytest.mark.slow),
    ],
)
def test_law_that_was_planted_is_proposed(torque: building.Torque, joints: int, column: str, value: float) -> None:
    found = proposal(torque, joints)
    assert found is not None
    assert found.columns[0] == column
    assert found.term.joints == tuple(range(joints))
    assert found.improvement.share > 0.98
    coefficient = found.after.solution.x[len(found.before.solution.x)]
    assert coefficient == pytest.approx(value, rel=0.03)


def test_nothing_is_proposed_where_nothing_is_left() -> None:
    assert proposal(lambda motion: 0.0 * motion.velocity) is None


def test_formula_takes_the_place_of_a_curve() -> None:
    """A curve over the position is a formula that waits: a stop, which begins at an angle."""

    def stop(motion: Motion) -> Floats:
        torque: Floats = 6.0 * np.maximum(motion.position - 0.2, 0)
        return torque

    train, held_out = (building.record(noise=0.05, extra=stop, shape=shape, seed=shape) for shape in (0, 1))
    model = building.fitted(building.split([train], [held_out]), "position_torque")
    found = propose(model, estimate_unexplained(model))
    assert found is not None
    assert found.before.names == set()
    assert found.columns == ("maximum(q - s, 0)",)
    assert found.shapes["s"] == pytest.approx(0.2, abs=0.02)
