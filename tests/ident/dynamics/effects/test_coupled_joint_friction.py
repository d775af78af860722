"""Friction of a joint's own bearing beside that of a motor which turns with another joint, too."""

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import load
from ident.dynamics.effects.quantities import columns
from ident.dynamics.mechanism_motion import MechanismMotion
from recordings.rig import simulated_rig
from tests.ident.dynamics.mechanisms.test_urdf import motion, rig

pytest.importorskip("pinocchio")

EFFECT = load("coupled_joint_friction")
WRIST = rig(couplings=({"of": 3, "by": 1, "ratio": 1.0},))


def test_only_a_joint_whose_motor_turns_with_another_can_have_it() -> None:
    assert EFFECT.possible_joints(WRIST) == (2,)
    assert EFFECT.possible_joints(rig()) == ()
    assert "no couplings" in str(EFFECT.why_unobservable(rig(), True, False))
    assert simulated_rig().mechanism not in EFFECT.mechanisms


def test_friction_of_bearing_and_motor_are_told_apart() -> None:
    assert isinstance(EFFECT, Additive)
    assert EFFECT.formula is not None
    mechanism, at = mechanisms.create(WRIST), motion()
    truth = np.arange(1.0, len(mechanism.parameters) + 3) / 10
    inputs = MechanismMotion(WRIST, at, mechanism).effect_inputs(
        100.0, np.arange(len(at.position)) / 100, 30.0, truth[:-2]
    )
    of_bearing = np.zeros((len(at.position), 3, 2))
    of_bearing[:, 2] = columns(EFFECT.formula, inputs, {})[:, 2]
    np.testing.assert_array_equal(of_bearing[:, 2], np.stack([at.velocity[:, 2], np.sign(at.velocity[:, 2])], axis=1))
    regressor = np.concatenate([mechanism.regressor(at), of_bearing], axis=2).reshape(-1, len(truth))
    found = np.linalg.lstsq(regressor, regressor @ truth, rcond=None)[0]
    np.testing.assert_allclose(found, truth, atol=1e-8)
