"""Torque of effects in motions that have not been recorded."""

import numpy as np
import pytest

from ident.design.model import DesignModel, mandatory_effects, with_effects
from ident.dynamics.effects.library import load
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.errors import BadInput
from recordings.rig import Axis, Rig, simulated_rig
from trajectories.checks import nominal_parameters

BENCH = Rig(name="bench", mechanism="axes", axes=(Axis(),))
INERTIA, VISCOUS = 0.4, 0.8


def wave(n: int = 400, rate: float = 200.0) -> Motion:
    time = np.arange(n)[:, None] / rate
    position, velocity = np.sin(3 * time), 3 * np.cos(3 * time)
    return Motion(position, velocity, -9 * position, np.sign(velocity))


def bench_model() -> DesignModel:
    return with_effects(BENCH, []).with_parameters(np.array([INERTIA, VISCOUS, 0.0]))


def test_columns_of_an_eccentric_encoder_are_those_of_position_velocity_and_acceleration() -> None:
    """True position q - a sin q: velocity changes by -a cos q q', acceleration by a (sin q q'^2 - cos q q'')."""
    motion = wave()
    columns = bench_model().columns(
        Term.on_all_joints("encoder_eccentricity", load("encoder_eccentricity"), BENCH), motion
    )
    q, velocity, acceleration = motion.position, motion.velocity, motion.acceleration
    expected = INERTIA * (np.sin(q) * velocity**2 - np.cos(q) * acceleration) - VISCOUS * np.cos(q) * velocity
    np.testing.assert_allclose(columns[:, :, 0], expected, atol=5e-3 * np.abs(expected).max())


def test_regressor_has_the_effects_behind_the_mechanism() -> None:
    model = with_effects(BENCH, ["quadratic_friction"])
    motion = wave()
    regressor = model.regressor(motion)
    assert [parameter.name for parameter in model.parameters] == ["I_1", "c_v1", "c_c1", "quadratic_friction.a1"]
    np.testing.assert_allclose(regressor[:, :, 3], motion.velocity * np.abs(motion.velocity))


def test_masses_of_the_rig_file_are_the_load() -> None:
    rig = simulated_rig()
    model = with_effects(rig, mandatory_effects(rig))
    by_name = dict(zip((parameter.name for parameter in model.parameters), model.values, strict=False))
    m_p, T_g, inertia = nominal_parameters(rig)
    assert (by_name["m_p"], by_name["T_g"], by_name["I_2"], by_name["c_v1"]) == (m_p, T_g, inertia, 0.0)


@pytest.mark.parametrize(
    ("effects", "message"),
    [
        (["stribeck", "stribeck"], "found twice"),
        (["back_emf"], "adds torque"),
        (["thermal_drift"], "does not change"),
    ],
)
def test_effects_that_are_no_torque_of_the_motion_are_refused(effects: list[str], message: str) -> None:
    with pytest.raises(BadInput, match=message):
        with_effects(BENCH, effects)
