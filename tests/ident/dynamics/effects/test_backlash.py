"""Initial guesses for backlash are suggested from the residual."""

from typing import Any

import numpy as np
import pytest

from ident.dynamics.effects.library import load
from ident.dynamics.flexible_joints import flexible_joints
from recordings.recording import Floats
from recordings.rig import simulated_rig
from tests.ident.dynamics.test_flexible_joints import swaying

RATE = 500.0
LIGHT = {"m_p": 0.3, "T_g": 0.3, "I_1": 0.21, "I_2": 0.22, "I_3": 0.23, "m_d": 0.0}


class SwayingInputs:
    """Inputs of three joints that sway, each with its own frequency and phase."""

    rig = simulated_rig()

    def __init__(self) -> None:
        self.motion = swaying(6.0, RATE)

    def flexible_joints(self, share: float) -> Any:
        return flexible_joints(self.rig, LIGHT, share, RATE)

    def motor_inertia(self, share: float) -> Floats:
        return share * np.array([LIGHT[f"I_{joint}"] for joint in (1, 2, 3)])


def test_motor_share_and_the_gap_of_every_joint_are_suggested() -> None:
    inputs: Any = SwayingInputs()
    joints, half_gap = inputs.flexible_joints(0.5), np.array([0.0, 1e-3, 3e-4])
    residual = joints.backlash_torque(inputs.motion, half_gap) - joints.rigid_torque(inputs.motion)
    smooth = np.apply_along_axis(lambda signal: np.convolve(signal, [0.25, 0.5, 0.25], "same"), 0, residual)
    suggest = load("backlash").suggest
    assert suggest
    best = suggest(inputs, smooth)[0]
    assert best["motor"] == pytest.approx(0.5, abs=0.03)
    assert best["b"][1:] == pytest.approx(half_gap[1:], rel=0.15)


def test_nothing_is_suggested_from_a_residual_of_zero() -> None:
    inputs: Any = SwayingInputs()
    suggest = load("backlash").suggest
    assert suggest
    assert suggest(inputs, np.zeros_like(inputs.motion.position)) == []
