"""The regressor, compared with mechanics derived from forward kinematics alone."""

import numpy as np
import pytest

from ident.dynamics.mechanisms import delta
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Geometry, Nominal, simulated_rig
from trajectories import kinematics

ROBOT = delta.create(simulated_rig())
GEOMETRY = Geometry()
G = np.array([0.0, 0.0, -9.81])


def angles(t: Floats) -> Floats:
    """Smooth motion (n, 3) [rad]."""
    phase = np.array([0.3, 1.4, 2.9])
    return 0.2 + 0.35 * np.sin(4 * t[:, None] + phase) + 0.1 * np.cos(9 * t[:, None] - 2 * phase)


def derivative(f: Floats, h: float) -> Floats:
    """Central difference of order four of samples f(-2h) ... f(2h)."""
    return (f[0] - 8 * f[1] + 8 * f[3] - f[4]) / (12 * h)


@pytest.fixture(scope="module")
def motion() -> Motion:
    t, h = np.linspace(0, 2, 60), 1e-3
    q = [angles(t + k * h) for k in (-2, -1, 0, 1, 2)]
    velocity = derivative(np.array(q), h)
    acceleration = (-q[0] + 16 * q[1] - 30 * q[2] + 16 * q[3] - q[4]) / (12 * h**2)
    return Motion(q[2], velocity, acceleration, np.sign(velocity))


@pytest.fixture(scope="module")
def platform_force() -> Floats:
    """Force (n, 3) on one kilogram at the platform, P_ddot - g, by finite differences of forward kinematics."""
    t, h = np.linspace(0, 2, 60), 1e-3
    P = [kinematics.forward(GEOMETRY, angles(t + k * h)) for k in (-2, -1, 0, 1, 2)]
    return (-P[0] + 16 * P[1] - 30 * P[2] + 16 * P[3] - P[4]) / (12 * h**2) - G


def virtual_work(theta: Floats, force: Floats) -> Floats:
    """Joint torques (n, 3) that balance a force (n, 3) at the platform, by virtual displacements of each joint."""
    h = 1e-4
    torque = np.empty_like(theta)
    for joint in range(3):
        turn = h * np.eye(3)[joint]
        P = np.array([kinematics.forward(GEOMETRY, theta + k * turn) for k in (-2, -1, 0, 1, 2)])
        torque[:, joint] = np.sum(derivative(P, h) * force, axis=1)
    return torque


def test_platform_column_is_virtual_work(motion: Motion, platform_force: Floats) -> None:
    column = ROBOT.regressor(motion)[:, :, 0]
    np.testing.assert_allclose(column, virtual_work(motion.position, platform_force), atol=1e-6)


def test_arm_columns_are_potential_and_kinetic_energy(motion: Motion) -> None:
    """Without platform, the power is what friction takes and the derivative of T_g sin(theta) + I theta_dot^2 / 2."""
    parameters = np.zeros(11)
    parameters[1:] = 5.0, 0.3, 0.4, 0.5, *[0.6] * 3, *[0.7] * 3
    power = np.sum(ROBOT.regressor(motion) @ parameters * motion.velocity, axis=1)
    t, h = np.linspace(0, 2, 60), 1e-3

    def energy(t: Floats) -> Floats:
        q = angles(t)
        speed = derivative(np.array([angles(t + k * h) for k in (-2, -1, 0, 1, 2)]), h)
        return np.sum(5.0 * np.sin(q) + np.array([0.3, 0.4, 0.5]) * speed**2 / 2, axis=1)

    growth = derivative(np.array([energy(t + k * h) for k in (-2, -1, 0, 1, 2)]), h)
    speed = np.abs(motion.velocity)
    np.testing.assert_allclose(power - (0.6 * speed**2 + 0.7 * speed).sum(axis=1), growth, atol=1e-5)


def test_nominal_model_is_table_1_with_the_rods_counted_twice(motion: Motion, platform_force: Floats) -> None:
    """Eqs. (1)-(2), with multipliers, agree with virtual work; as printed but for g = -9.81."""
    nominal = Nominal()
    on_platform = virtual_work(motion.position, (nominal.m_p + 3 * nominal.m_d) * platform_force)
    inertia = nominal.motor_inertia + nominal.I_L1 + GEOMETRY.L1**2 * nominal.m_d
    moment = nominal.m_a * nominal.L1c + nominal.m_d * GEOMETRY.L1
    on_arms = inertia * motion.acceleration + moment * 9.81 * np.cos(motion.position)
    np.testing.assert_allclose(ROBOT.nominal_torque(motion), on_platform + on_arms, atol=1e-5)
