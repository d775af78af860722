import numpy as np
import pytest

from drivers.simulated.base_model_residual import BANDWIDTH, JointMotion, base_columns, base_model_residual
from drivers.simulated.config import Links
from recordings.recording import Floats
from recordings.rig import Geometry
from tests.drivers.simulated.exact_delta import exact_torque

GEOMETRY = Geometry()
DT = 1e-3
TIME = np.arange(4000) * DT
INSIDE = slice(500, -500)


def _motion() -> JointMotion:
    """Two harmonics per joint, torque of the exact robot without friction."""
    position, velocity, acceleration = (np.zeros((len(TIME), 3)) for _ in range(3))
    for joint, harmonics in enumerate([(1, 3), (2, 3), (1, 4)]):
        for harmonic in harmonics:
            w = 2 * np.pi * harmonic / 2
            position[:, joint] += 0.15 * np.sin(w * TIME + joint)
            velocity[:, joint] += 0.15 * w * np.cos(w * TIME + joint)
            acceleration[:, joint] -= 0.15 * w**2 * np.sin(w * TIME + joint)
    torque = exact_torque(GEOMETRY, Links(), position, velocity, acceleration)
    return JointMotion(position=position, velocity=velocity, acceleration=acceleration, torque=torque)


def _rms(values: Floats) -> Floats:
    """(3,) per joint."""
    rms: Floats = np.sqrt(np.mean(values**2, axis=0))
    return rms


def _with(motion: JointMotion, extra: Floats) -> JointMotion:
    return JointMotion(motion.position, motion.velocity, motion.acceleration, motion.torque + extra)


def test_columns_times_true_parameters_equal_the_exact_torque() -> None:
    motion, links = _motion(), Links()
    half = links.rod_mass / 2
    inertia = links.motor_inertia + links.arm_inertia + links.arm_mass * links.arm_com**2 + half * GEOMETRY.L1**2
    weight = 9.81 * (links.arm_mass * links.arm_com + half * GEOMETRY.L1)
    parameters = [inertia] * 3 + [weight, links.platform_mass + 3 * half] + [0.0] * 6 + [links.rod_mass]
    assert base_columns(GEOMETRY, motion) @ parameters == pytest.approx(motion.torque, abs=2e-4)


def test_torque_of_the_base_model_has_no_residual() -> None:
    motion = _motion()
    friction = np.array([0.3, 0.5, 0.1]) * motion.velocity + np.array([0.9, 0.2, 0.4]) * np.sign(motion.velocity)
    fit = base_model_residual(GEOMETRY, _with(motion, friction), DT, INSIDE, 5)
    assert np.all(_rms(fit.residual) < 1e-4 * _rms(fit.torque))


@pytest.mark.parametrize("frequency", [17.3, BANDWIDTH])
def test_unmodelled_ripple_remains_in_the_residual_attenuated_by_three_decibels_at_the_bandwidth(
    frequency: float,
) -> None:
    ripple = np.zeros((len(TIME), 3))
    ripple[:, 1] = np.sin(2 * np.pi * frequency * TIME)
    fit = base_model_residual(GEOMETRY, _with(_motion(), ripple), DT, INSIDE, 1)
    attenuation = 1 / (1 + (np.sqrt(2) - 1) * (frequency / BANDWIDTH) ** 4)
    assert np.sqrt(2) * _rms(fit.residual)[1] == pytest.approx(attenuation, rel=0.02)
    assert _rms(fit.residual)[[0, 2]].max() < 0.05


def test_fit_with_a_joint_at_rest() -> None:
    motion = _motion()
    still = JointMotion(
        motion.position * [1, 1, 0], motion.velocity * [1, 1, 0], motion.acceleration * [1, 1, 0], motion.torque
    )
    torque = exact_torque(GEOMETRY, Links(), still.position, still.velocity, still.acceleration)
    fit = base_model_residual(
        GEOMETRY, JointMotion(still.position, still.velocity, still.acceleration, torque), DT, INSIDE, 5
    )
    assert np.all(_rms(fit.residual) < 1e-4 * _rms(fit.torque).mean())
