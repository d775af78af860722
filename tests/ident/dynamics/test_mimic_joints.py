"""Joints that mimic others: against closed loops, and the same links with all joints driven."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.dynamics.rigid_chain import rigid_chain
from tests.ident.dynamics.loops import four_bar_keys, mimicking, rig
from tests.ident.dynamics.mechanisms.test_urdf import motion, urdf

pytest.importorskip("pinocchio")


def test_parallelogram_is_that_of_a_closed_loop() -> None:
    """The arm of a palletiser, whose coupler never turns."""
    text = mimicking(four_bar_keys()["urdf"], elbow=("drive", -1.0, 0.0), pivot=("drive", 1.0, 0.0))
    by_loop, by_mimic = (mechanisms.create(rig(k)) for k in (four_bar_keys(), {"urdf": text, "joints": ("drive",)}))
    assert by_mimic.parameters == by_loop.parameters
    np.testing.assert_allclose(by_mimic.regressor(motion(1)), by_loop.regressor(motion(1)), atol=1e-9)
    np.testing.assert_allclose(by_mimic.nominal_torque(motion(1)), by_loop.nominal_torque(motion(1)), atol=1e-9)  # type: ignore[arg-type]


@settings(max_examples=30, deadline=None)
@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-2, 2), st.floats(-1, 1))
def test_torque_is_that_of_all_joints_times_their_motion_by_the_driven(
    multiplier: float, offset: float, second: float, bias: float
) -> None:
    """The slide mimics the swing, and the hand mimics the slide."""
    text = mimicking(urdf(), j2=("j1", multiplier, offset), j3=("j2", second, bias))
    load = {"payload": {"mass": 0.7, "com": (0.1, 0.0, 0.2)}, "tool": "l3"}
    one = rigid_chain(rig({"urdf": text, "joints": ("j1",), **load}).chain)
    every = rigid_chain(rig({"urdf": urdf(), "joints": ("j1", "j2", "j3"), **load}).chain)
    S, at = np.array([1.0, multiplier, second * multiplier]), motion(1)
    q = S * at.position + [0.0, offset, second * offset + bias]
    expected = (
        every.nominal_torque(Motion(q, *(S * rate for rate in (at.velocity, at.acceleration, at.velocity)))) @ S
    )
    for torque in (one.nominal_torque(at), one.regressor(at) @ one.nominal_parameters):
        np.testing.assert_allclose(torque[:, 0], expected, atol=1e-9 * np.abs(expected).max())


def test_joints_that_mimic_fixed_ones_stand_and_fixed_ones_mimic_none() -> None:
    text = mimicking(urdf(), j2=("j3", 2.0, 0.1), j3=("j1", 1.0, 0.0))
    mimics = rig({"urdf": text, "joints": ("j1",), "fixed": {"j3": 0.3}})
    assert (mimics.following, mimics.standing) == ((), {"j3": 0.3, "j2": 0.7})
    told = rig({"urdf": urdf(), "joints": ("j1",), "fixed": mimics.standing})
    torques = (rigid_chain(robot.chain).nominal_torque(motion(1)) for robot in (mimics, told))
    np.testing.assert_allclose(*torques, atol=1e-12)
