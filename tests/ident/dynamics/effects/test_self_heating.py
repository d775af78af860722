"""Friction that falls as a joint warms itself."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.dynamics.effects.library import load
from ident.dynamics.effects.library.self_heating import columns
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import simulated_rig
from tests.ident import building

C_V, C_C, T, RATE = 0.8, 1.5, 6.0, 250.0
K = -0.2


def column(velocity: Floats) -> Floats:
    """(n, dof) of a motion with this velocity."""
    motion = Motion(velocity, velocity, velocity, np.sign(velocity))
    names = {f"{name}{i}": value for i in range(1, 4) for name, value in (("c_v", C_V), ("c_c", C_C))}
    inputs: Any = SimpleNamespace(motion=motion, rate=RATE, parameters=names)
    return columns(inputs, {"T": T})[:, :, 0]


def test_at_constant_speed_the_warmth_rises_to_one() -> None:
    velocity = np.array([[1.0, -2.0]]) * np.ones((5000, 1))
    warmth = 1 - np.exp(-np.arange(5000) / (RATE * T))
    np.testing.assert_allclose(column(velocity), warmth[:, None] * (C_V * velocity + C_C * np.sign(velocity)))


def test_the_joint_cools_while_it_stands_and_a_joint_that_never_moves_stays_cold() -> None:
    velocity = np.zeros((6000, 2))
    velocity[:2000, 0] = velocity[4000:, 0] = 1.0
    warm = column(velocity)
    assert warm[4000, 0] == pytest.approx(warm[1999, 0] * np.exp(-2000 / (RATE * T)), rel=0.01)
    assert not warm[:, 1].any()


def test_a_gap_is_passed_at_the_mean_power() -> None:
    velocity = np.ones((5000, 1))
    gapped = velocity.copy()
    gapped[1000:2000] = np.nan
    after = slice(2000, None)
    np.testing.assert_allclose(column(gapped)[after], column(velocity)[after])
    assert np.isnan(column(gapped)[1000:2000]).all()


def test_it_is_offered_only_without_a_thermometer() -> None:
    effect = load("self_heating")
    assert "temperature_friction" in str(effect.why_unobservable(simulated_rig(), True, True))
    assert effect.why_unobservable(simulated_rig(), True, False) is None


def heated(motion: Motion) -> Floats:
    """(n, 1) torque that is missing from the cold friction."""
    friction = building.VISCOUS * motion.velocity + building.COULOMB * motion.direction
    power = friction * motion.velocity
    warmth, change = np.zeros_like(power), np.full_like(power, 1 / (building.RATE * T))
    for k in range(1, len(power)):
        warmth[k] = warmth[k - 1] + change[k] * (power[k - 1] / power.mean() - warmth[k - 1])
    return K * warmth * friction


def test_it_is_named_where_a_joint_warms_itself() -> None:
    recordings = (
        building.record(noise=0.05, seed=seed, shape=seed, extra=heated, name=f"motion {seed}") for seed in (0, 1000)
    )
    first = building.named(*recordings)[0]
    assert "self_heating" in first
    assert set(first) <= {"self_heating", "thermal_drift"}
