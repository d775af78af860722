"""Friction of the balls of a delta: its torque is the derivative of what is dissipated by the joints' rates."""

import numpy as np

from ident.dynamics.arm_kernels import balls_along
from ident.dynamics.platform import kernel_constants
from recordings.recording import Floats
from recordings.rig import simulated_rig
from trajectories import kinematics

GEOMETRY = simulated_rig().geometry
STEP = 1e-6
RNG = np.random.default_rng(3)
Q, V = RNG.uniform(-0.2, 0.6, (40, 3)), RNG.uniform(-3.0, 3.0, (40, 3))


def directions(q: Floats) -> tuple[Floats, Floats]:
    """Unit vectors (n, 3, 3) along arms and rods, limb by limb."""
    phi = np.array(GEOMETRY.phi)
    out = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)
    arm = np.cos(q)[:, :, None] * out + np.sin(q)[:, :, None] * np.array([0.0, 0.0, 1.0])
    elbow = (GEOMETRY.R - GEOMETRY.r) * out + GEOMETRY.L1 * arm
    return arm, (kinematics.forward(GEOMETRY, q)[:, None, :] - elbow) / GEOMETRY.L2


def power(v: Floats, exponent: int) -> Floats:
    """(n,) sum of |w| or of w^2 / 2 over the balls, by differences of the positions."""
    ahead, behind = (directions(Q + sign * STEP * v) for sign in (1, -1))
    here = directions(Q)
    arm, rod = (np.cross(u, (a - b) / (2 * STEP)) for u, a, b in zip(here, ahead, behind, strict=True))
    spins = np.stack([rod, rod - arm])
    dissipated: Floats = (np.linalg.norm(spins, axis=3) ** exponent / exponent).sum(axis=(0, 2))
    return dissipated


def test_torque_is_the_derivative_of_the_dissipation() -> None:
    torques = balls_along(kernel_constants(GEOMETRY), Q, V)
    for exponent, torque in enumerate(torques, start=1):
        slopes = [(power(V + 1e-3 * unit, exponent) - power(V - 1e-3 * unit, exponent)) / 2e-3 for unit in np.eye(3)]
        np.testing.assert_allclose(torque, np.stack(slopes, axis=1), atol=1e-4 * np.abs(torque).max())


def test_a_standing_joint_feels_the_rods_that_others_move_and_nothing_at_rest() -> None:
    moving = np.tile([1.0, 0.0, 0.0], (len(Q), 1))
    assert (np.abs(balls_along(kernel_constants(GEOMETRY), Q, moving)[:, :, 1:]).max(axis=1) > 0.1).all()
    assert not balls_along(kernel_constants(GEOMETRY), Q, 0 * V).any()
