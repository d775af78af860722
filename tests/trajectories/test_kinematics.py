"""Kinematics checked by round trips, finite differences and the closure constraint."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Geometry, Limits
from trajectories import kinematics
from trajectories.kinematics import Unreachable

GEOMETRY = Geometry()

lengths = st.builds(
    Geometry,
    L1=st.floats(0.3, 0.4),
    L2=st.floats(0.75, 0.9),
    R=st.floats(0.1, 0.25),
    r=st.floats(0.03, 0.1),
)


def poses(seed: int, n: int) -> Floats:
    """Platform positions over the whole workspace of the default limits."""
    generator = np.random.default_rng(seed)
    limits = Limits()
    radius = limits.workspace_radius * np.sqrt(generator.uniform(0, 1, n))
    angle = generator.uniform(0, 2 * np.pi, n)
    height = generator.uniform(-0.95, -0.55, n)
    return np.column_stack([radius * np.cos(angle), radius * np.sin(angle), height])


def reachable(geometry: Geometry, P: Floats) -> Floats:
    """The rows of P that `inverse` accepts."""
    kept = []
    for row in P:
        try:
            kinematics.inverse(geometry, row[None])
        except Unreachable:
            continue
        kept.append(row)
    return np.array(kept).reshape(-1, 3)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_forward_undoes_inverse_at_ten_thousand_poses(seed: int) -> None:
    generator = np.random.default_rng(seed)
    theta = generator.uniform(-0.8, 1.0, (10_000, 3))
    P = kinematics.forward(GEOMETRY, theta)
    again = kinematics.inverse(GEOMETRY, P)
    assert np.abs(kinematics.forward(GEOMETRY, again) - P).max() < 1e-12
    assert np.abs(again - theta).max() < 1e-12


@given(geometry=lengths, seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_forearms_of_any_robot_keep_their_length_with_elbows_out(geometry: Geometry, seed: int) -> None:
    P = reachable(geometry, poses(seed, 50))
    theta = kinematics.inverse(geometry, P)
    margin = kinematics.singularity_margin(geometry, theta, P)
    assert ((margin > 0) & (margin <= 1)).all()
    clear = margin > 0.02
    assert clear.mean() > 0.5
    assert np.abs(kinematics.forward(geometry, theta) - P)[clear].max() < 1e-12
    for limb, phi in enumerate(geometry.phi):
        outward = np.array([np.cos(phi), np.sin(phi), 0.0])
        elbow = (geometry.R + geometry.L1 * np.cos(theta[:, limb, None])) * outward
        elbow[:, 2] = geometry.L1 * np.sin(theta[:, limb])
        rod = P + geometry.r * outward - elbow
        assert np.linalg.norm(rod, axis=1) == pytest.approx(geometry.L2, abs=1e-12)
        # Elbows out: lifting the elbow lifts the platform.
        tangent = -np.sin(theta[:, limb, None]) * outward + np.cos(theta[:, limb, None]) * np.array([0, 0, 1.0])
        assert (np.einsum("ni,ni->n", rod, tangent) < 0).all()


def smooth_motion(time: Floats) -> Floats:
    phase = np.outer(time, [1.0, 1.7, 2.3]) + np.array([0.0, 1.0, 2.0])
    return 0.1 + 0.6 * np.sin(phase)


def test_motion_of_the_platform_agrees_with_finite_differences_and_is_undone() -> None:
    step = 1e-4
    time = np.linspace(0, 10, 500)
    before, now, after = (smooth_motion(time + shift) for shift in (-step, 0.0, step))
    theta_dot, theta_ddot = (after - before) / (2 * step), (after - 2 * now + before) / step**2
    P_before, P_after = (kinematics.forward(GEOMETRY, theta) for theta in (before, after))
    P, P_dot, P_ddot, J = kinematics.platform_motion(GEOMETRY, now, theta_dot, theta_ddot)
    np.testing.assert_array_equal(P, kinematics.forward(GEOMETRY, now))
    assert P_dot == pytest.approx((P_after - P_before) / (2 * step), abs=1e-6)
    assert P_ddot == pytest.approx((P_after - 2 * P + P_before) / step**2, abs=1e-6)
    assert P_dot == pytest.approx(np.einsum("nij,nj->ni", J, theta_dot), abs=1e-12)
    joint_motion = kinematics.joint_motion(GEOMETRY, now, P, P_dot, P_ddot)
    np.testing.assert_allclose(joint_motion, (theta_dot, theta_ddot), atol=1e-9)


def test_margin_vanishes_where_arm_and_rod_align_and_where_the_rods_are_coplanar() -> None:
    height = np.sqrt((GEOMETRY.L1 + GEOMETRY.L2) ** 2 - (GEOMETRY.R - GEOMETRY.r) ** 2)
    P = np.array([[0.0, 0.0, -0.7], [0.0, 0.0, -height * (1 - 1e-12)], [0.0, 0.0, GEOMETRY.L1 * np.sin(0.5)]])
    theta = np.vstack([kinematics.inverse(GEOMETRY, P[:2]), np.full(3, 0.5)])
    clear, aligned, coplanar = kinematics.singularity_margin(GEOMETRY, theta, P)
    assert clear > 0.3
    assert aligned < 1e-5
    assert coplanar < 1e-15


def test_unknown_and_singular_rows_are_not_finite_and_give_no_warnings() -> None:
    theta, rates = np.zeros((3, 3)), np.ones((3, 3))
    theta[1, 2] = np.nan
    P, *derivatives = kinematics.platform_motion(GEOMETRY, theta, rates, rates)
    margin, back = (
        kinematics.singularity_margin(GEOMETRY, theta, P),
        kinematics.joint_motion(GEOMETRY, theta, P, rates, rates),
    )
    for result in (P, *derivatives, margin, *back):
        assert np.isnan(result).reshape(3, -1).any(axis=1).tolist() == [False, True, False]
    speed, _ = kinematics.joint_motion(GEOMETRY, rates - 1, rates - 1, rates, rates - 1)
    assert not np.isfinite(speed).any()


HOME = [0.0, 0.0, -0.7]
SHORT = 1e3 * (np.hypot(GEOMETRY.R - GEOMETRY.r, 1.2) - GEOMETRY.L1 - GEOMETRY.L2)
UNREACHABLE = {
    "below": ([0.0, 0.0, -1.2], rf"limb 1 cannot reach \(0.0000, 0.0000, -1.2000\) m, .* {SHORT:.3f} mm too short"),
    # Away from limb 2, which points along -x.
    "aside": ([0.75, 0.0, -0.7], r"limb 2 cannot reach"),
    "near": ([0.01, 0.0, -0.1], r"limb 1 cannot reach .* mm too long; move the path towards"),
    "above": ([0.0, 0.0, 0.7], r"mm above the plane of its elbows; lower the path"),
}
"""Platform position, and words of the error."""


@pytest.mark.parametrize("name", UNREACHABLE)
def test_position_that_cannot_be_reached_is_refused_with_row_limb_and_excess(name: str) -> None:
    position, words = UNREACHABLE[name]
    with pytest.raises(Unreachable, match=f"^row 1: .*{words}") as caught:
        kinematics.inverse(GEOMETRY, np.array([HOME, position]))
    assert str(caught.value.at("t = 1.250 s")) == str(caught.value).replace("row 1", "t = 1.250 s")


def test_angles_at_which_the_mechanism_does_not_close_and_gaps_are_refused() -> None:
    with pytest.raises(Unreachable, match="row 1: the joint angles tear the mechanism apart"):
        kinematics.forward(GEOMETRY, np.array([[0.0, 0.0, 0.0], [-1.92, 0.49, -2.16]]))
    for value in (np.nan, np.inf):
        with pytest.raises(BadInput, match="row 1: a finite platform position expected"):
            kinematics.inverse(GEOMETRY, np.array([HOME, [0.0, value, -0.7]]))
