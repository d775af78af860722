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
def test_forward_undoes_inverse_for_other_geometries(geometry: Geometry, seed: int) -> None:
    P = reachable(geometry, poses(seed, 100))
    theta = kinematics.inverse(geometry, P)
    clear = kinematics.singularity_margin(geometry, theta, P) > 0.02
    assert clear.mean() > 0.5
    assert np.abs(kinematics.forward(geometry, theta) - P)[clear].max() < 1e-12


@given(geometry=lengths, seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_forearms_keep_their_length_with_elbows_out(geometry: Geometry, seed: int) -> None:
    P = reachable(geometry, poses(seed, 50))
    theta = kinematics.inverse(geometry, P)
    for limb, phi in enumerate(geometry.phi):
        outward = np.array([np.cos(phi), np.sin(phi), 0.0])
        elbow = (geometry.R + geometry.L1 * np.cos(theta[:, limb, None])) * outward
        elbow[:, 2] = geometry.L1 * np.sin(theta[:, limb])
        rod = P + geometry.r * outward - elbow
        assert np.linalg.norm(rod, axis=1) == pytest.approx(geometry.L2, abs=1e-12)
        # Elbows out: lifting the elbow lifts the platform.
        tangent = -np.sin(theta[:, limb, None]) * outward + np.cos(theta[:, limb, None]) * np.array([0, 0, 1.0])
        assert (np.einsum("ni,ni->n", rod, tangent) < 0).all()


def test_equal_angles_put_the_platform_below_the_centre() -> None:
    P = kinematics.forward(GEOMETRY, np.zeros((1, 3)))
    reach = GEOMETRY.R - GEOMETRY.r + GEOMETRY.L1
    assert P[0] == pytest.approx([0, 0, -np.sqrt(GEOMETRY.L2**2 - reach**2)], abs=1e-14)


def test_positive_angle_lifts_the_elbow_and_the_platform() -> None:
    P = kinematics.forward(GEOMETRY, np.array([[0.0, 0, 0], [0.1, 0.1, 0.1]]))
    assert P[1, 2] > P[0, 2]


def smooth_motion(time: Floats) -> Floats:
    phase = np.outer(time, [1.0, 1.7, 2.3]) + np.array([0.0, 1.0, 2.0])
    return 0.1 + 0.6 * np.sin(phase)


def test_jacobian_and_its_derivative_agree_with_finite_differences() -> None:
    step = 1e-5
    time = np.linspace(0, 10, 500)
    before, now, after = (smooth_motion(time + shift) for shift in (-step, 0.0, step))
    theta_dot = (after - before) / (2 * step)
    P_before, P, P_after = (kinematics.forward(GEOMETRY, theta) for theta in (before, now, after))
    J = kinematics.jacobian(GEOMETRY, now, P)
    J_dot = kinematics.jacobian_derivative(GEOMETRY, now, P, theta_dot, J)
    P_dot = np.einsum("nij,nj->ni", J, theta_dot)
    assert P_dot == pytest.approx((P_after - P_before) / (2 * step), abs=1e-8)
    difference = kinematics.jacobian(GEOMETRY, after, P_after) - kinematics.jacobian(GEOMETRY, before, P_before)
    assert J_dot == pytest.approx(difference / (2 * step), abs=1e-8)


def test_joint_motion_is_consistent_with_the_jacobian() -> None:
    generator = np.random.default_rng(1)
    theta, theta_dot, theta_ddot = (generator.uniform(-0.5, 0.5, (200, 3)) * scale for scale in (1, 8, 100))
    P = kinematics.forward(GEOMETRY, theta)
    J = kinematics.jacobian(GEOMETRY, theta, P)
    J_dot = kinematics.jacobian_derivative(GEOMETRY, theta, P, theta_dot, J)
    P_dot = np.einsum("nij,nj->ni", J, theta_dot)
    P_ddot = np.einsum("nij,nj->ni", J, theta_ddot) + np.einsum("nij,nj->ni", J_dot, theta_dot)
    speed, acceleration = kinematics.joint_motion(GEOMETRY, theta, P, P_dot, P_ddot)
    assert speed == pytest.approx(theta_dot, abs=1e-11)
    assert acceleration == pytest.approx(theta_ddot, abs=1e-9)


def test_margin_vanishes_where_arm_and_rod_align() -> None:
    height = np.sqrt((GEOMETRY.L1 + GEOMETRY.L2) ** 2 - (GEOMETRY.R - GEOMETRY.r) ** 2)
    P = np.array([[0.0, 0.0, -0.7], [0.0, 0.0, -height * (1 - 1e-12)]])
    margin = kinematics.singularity_margin(GEOMETRY, kinematics.inverse(GEOMETRY, P), P)
    assert margin[0] > 0.3
    assert margin[1] < 1e-5


def test_margin_vanishes_where_the_rods_are_coplanar() -> None:
    theta = np.full((1, 3), 0.5)
    level = np.array([[0.0, 0.0, GEOMETRY.L1 * np.sin(0.5)]])
    assert kinematics.singularity_margin(GEOMETRY, theta, level)[0] < 1e-15


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_singularity_margin_is_between_zero_and_one(seed: int) -> None:
    P = reachable(GEOMETRY, poses(seed, 50))
    margin = kinematics.singularity_margin(GEOMETRY, kinematics.inverse(GEOMETRY, P), P)
    assert ((margin > 0) & (margin <= 1)).all()


def test_nan_rows_give_nan_without_warnings() -> None:
    theta = np.zeros((3, 3))
    theta[1, 2] = np.nan
    P = kinematics.forward(GEOMETRY, theta)
    J = kinematics.jacobian(GEOMETRY, theta, P)
    rates = np.ones((3, 3))
    results = (
        P,
        J,
        kinematics.jacobian_derivative(GEOMETRY, theta, P, rates, J),
        kinematics.singularity_margin(GEOMETRY, theta, P),
        *kinematics.joint_motion(GEOMETRY, theta, P, rates, rates),
    )
    for result in results:
        gap = np.isnan(result).reshape(3, -1).any(axis=1)
        assert gap.tolist() == [False, True, False]


def test_singular_rows_are_not_finite_and_give_no_warnings() -> None:
    theta, level = np.zeros((1, 3)), np.zeros((1, 3))
    J = kinematics.jacobian(GEOMETRY, theta, level)
    assert not np.isfinite(J).any()
    assert not np.isfinite(kinematics.jacobian_derivative(GEOMETRY, theta, level, theta + 1, J)).any()
    speed, _ = kinematics.joint_motion(GEOMETRY, theta, level, theta + 1, theta)
    assert not np.isfinite(speed).any()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_inverse_refuses_nan_and_infinity(value: float) -> None:
    P = poses(0, 4)
    P[2, 1] = value
    with pytest.raises(BadInput, match="row 2: a finite platform position expected"):
        kinematics.inverse(GEOMETRY, P)


def test_error_for_a_distant_position_names_row_limb_and_excess() -> None:
    P = np.array([[0.0, 0.0, -0.7], [0.0, 0.0, -1.2]])
    reach = np.hypot(GEOMETRY.R - GEOMETRY.r, 1.2)
    with pytest.raises(Unreachable, match="row 1: limb 1 cannot reach") as caught:
        kinematics.inverse(GEOMETRY, P)
    assert caught.value.row == 1
    assert caught.value.excess == pytest.approx(reach - GEOMETRY.L1 - GEOMETRY.L2)
    assert f"{1e3 * caught.value.excess:.3f} mm too short" in str(caught.value)


def test_error_for_a_distant_position_names_the_limb_that_cannot_reach() -> None:
    # Away from limb 2, which points along -x.
    with pytest.raises(Unreachable) as caught:
        kinematics.inverse(GEOMETRY, np.array([[0.75, 0.0, -0.7]]))
    assert caught.value.limb == 2


def test_error_for_a_near_position_says_that_the_forearm_is_too_long() -> None:
    with pytest.raises(Unreachable, match="mm too long"):
        kinematics.inverse(GEOMETRY, np.array([[0.0, 0.0, -0.1]]))


def test_platform_above_its_elbows_is_refused() -> None:
    with pytest.raises(Unreachable, match="above the plane of its elbows"):
        kinematics.inverse(GEOMETRY, np.array([[0.0, 0.0, 0.7]]))


def test_forward_refuses_angles_at_which_the_mechanism_does_not_close() -> None:
    theta = np.array([[0.0, 0.0, 0.0], [-1.92, 0.49, -2.16]])
    with pytest.raises(Unreachable, match="row 1: the joint angles tear the mechanism apart") as caught:
        kinematics.forward(GEOMETRY, theta)
    assert caught.value.limb is None
    assert caught.value.excess > 0


def test_unreachable_error_names_the_instant_in_place_of_the_row() -> None:
    with pytest.raises(Unreachable) as caught:
        kinematics.inverse(GEOMETRY, np.array([[0.0, 0.0, -1.2]]))
    placed = caught.value.at("t = 1.250 s")
    assert str(placed).startswith("t = 1.250 s: limb 1 cannot reach")
    assert placed.excess == caught.value.excess
