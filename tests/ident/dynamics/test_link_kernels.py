"""Trees of links in the compiled kernels, compared with Pinocchio, and with MuJoCo behind springs and gaps."""

from functools import partial
from types import SimpleNamespace
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from benchmarks import flexible_arms
from ident.basics.filters import convolve, low_pass
from ident.dynamics import mechanisms
from ident.dynamics.arm_kernels import dynamics_along
from ident.dynamics.effects.library import load
from ident.dynamics.flexible_joints import FlexibleJoints, flexible_joints
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Rig, simulated_rig
from tests.ident.dynamics.loops import four_bar_keys, joint, link, mimicking, rig, robot

pytest.importorskip("pinocchio")

RATE = 250.0
ARM = {"upper": (4.0, 0.3, 0.05), "fore": (2.0, 0.25, 0.02)}
"""Mass [kg], place of the centre [m] and moment of inertia about it [kg m^2] of two links of 0.5 m."""


def _tree() -> Rig:
    """A turret with a sliding arm and a turning one, joints in another order, of which two motors are coupled."""
    parts = [
        link("base"),
        *(link(name, 1.0, (0.1, 0.2, 0.3), (0.1, 0.2, 0.2)) for name in ("turret", "slide", "arm")),
        joint("turn", "base", "turret", "0 0 1", (0.1, 0, 0.3), 0.4),
        joint("push", "turret", "slide", "0 0.6 0.8", (0.2, -0.1, 0), 0.7, kind="prismatic"),
        joint("swing", "turret", "arm", "0.6 0.8 0", (0, 0.3, 0.2), -0.3),
    ]
    coupled = ({"of": 1, "by": 2, "ratio": 0.8},)
    return rig({"urdf": robot(parts), "joints": ("swing", "turn", "push"), "couplings": coupled})


def _mechanism(of: Rig) -> Urdf:
    mechanism = mechanisms.create(of)
    assert isinstance(mechanism, Urdf)
    return mechanism


def _joints(of: Rig, base: Floats, rate: float = RATE) -> FlexibleJoints:
    """Joints of links with these `base` parameters, without friction; motors have no inertia."""
    named = _mechanism(of).parameters
    parameters = {
        each.name: float(x) for each, x in zip(named, np.pad(base, (0, len(named) - len(base))), strict=True)
    }
    return flexible_joints(of, parameters, 0.0, rate)


def test_torque_and_inertia_of_a_tree_are_those_of_its_columns() -> None:
    tree = _tree()
    mechanism = _mechanism(tree)
    motion, base = (
        mechanism.links.random_motion(50),
        np.random.default_rng(1).normal(size=len(mechanism.base.columns)),
    )
    joints = _joints(tree, base)
    expected = mechanism.regressor(motion)[:, :, : len(base)] @ base
    np.testing.assert_allclose(joints.rigid_torque(motion), expected, atol=1e-9)
    signals = motion.position, motion.velocity, motion.acceleration
    inertia = dynamics_along(2, joints.constants, *signals)[1]
    whole = mechanism.inertia(motion, np.pad(base, (0, 9)))
    np.testing.assert_allclose(inertia, np.diagonal(whole, axis1=1, axis2=2), atol=1e-7)


def _arm() -> tuple[FlexibleJoints, Motion, Any, Floats]:
    """Two links that swing in a vertical plane, their motors' motion, MuJoCo's model of them, and the time."""
    parts, bodies, at = [link("base")], "", (0.0, 0.0, 0.0)
    for parent, (name, (mass, centre, moment)) in zip(("base", "upper"), ARM.items(), strict=True):
        parts += [link(name, mass, (centre, 0, 0), (moment,) * 3), joint(name, parent, name, "0 1 0", at)]
        bodies += (
            f'<body pos="{at[0]} 0 0"><joint axis="0 1 0"/><inertial pos="{centre} 0 0" mass="{mass}" '
            f'diaginertia="{moment} {moment} {moment}"/>'
        )
        at = (0.5, 0.0, 0.0)
    model = mujoco.MjModel.from_xml_string(f"<mujoco><worldbody>{bodies}</body></body></worldbody></mujoco>")
    described, time = (
        rig({"urdf": robot(parts), "joints": tuple(ARM), "motor_inertia": False}),
        np.arange(0, 3, 1 / RATE),
    )
    mechanism, begun = _mechanism(described), np.clip(time / 1.5, 0, 1)[:, None]
    swell = begun**4 * (35 - 84 * begun + 70 * begun**2 - 20 * begun**3)
    path = CubicSpline(time, swell * 0.3 * np.sin(2 * np.pi * np.array([1.4, 2.1]) * time[:, None]))
    motion = Motion(path(time), path(time, 1), path(time, 2), np.sign(path(time, 1)))
    return _joints(described, mechanism.base.combination @ mechanism.known_parameters), motion, model, time


@pytest.mark.parametrize("coupling", ["springs", "gaps"])
def test_an_arm_behind_springs_or_gaps_moves_as_in_mujoco(coupling: str) -> None:
    joints, motion, model, time = _arm()
    motors = (motion.position, motion.velocity, motion.acceleration)
    if coupling == "springs":
        torque, error = joints.elastic_torque(motion, np.array([2e-4, 0.0]), 0.04), 0.02
        expected = flexible_arms.arm_torque(
            model, time, motors, [0], lambda inertia: flexible_arms.spring(2e-4 * inertia, inertia)
        )
    else:
        torque, error = joints.backlash_torque(motion, np.array([0.0, 2e-3])), 0.35  # the other's stops give way
        expected = flexible_arms.arm_torque(model, time, motors, [1], partial(flexible_arms.gap, 2e-3))
    taps = low_pass(25.0, RATE)
    difference, change = (convolve(each, taps) for each in (torque - expected, torque - joints.rigid_torque(motion)))
    assert np.nanstd(difference[125:]) < error * np.nanstd(change[125:])


@pytest.mark.parametrize("name", ["joint_elasticity", "backlash"])
def test_joints_that_follow_others_have_neither_springs_nor_gaps(name: str) -> None:
    text = mimicking(four_bar_keys()["urdf"], elbow=("drive", -1.0, 0.0), pivot=("drive", 1.0, 0.0))
    for keys in (four_bar_keys(), {"urdf": text, "joints": ("drive",)}):
        reason = load(name).impossible(rig(keys), 0)
        assert reason
        assert "mimic joints" in reason
    assert load(name).impossible(_tree(), 0) is None


def test_springs_of_all_joints_are_tried_at_the_same_natural_frequencies() -> None:
    """The shoulder has to move both links."""
    joints, motion, *_ = _arm()
    inertia = dynamics_along(2, joints.constants, motion.position, motion.velocity, motion.acceleration)[1].min(
        axis=0
    )
    assert inertia[0] > 4 * inertia[1]
    inputs: Any = SimpleNamespace(rig=_tree(), motor_inertia=lambda share: share * inertia)
    scale = load("joint_elasticity").guess_scale(inputs)
    frequency = np.sqrt(1 / (1e-4 * scale * inertia)) / (2 * np.pi)
    np.testing.assert_allclose(frequency, 40.0, rtol=0.2)
    inputs.rig = simulated_rig()
    np.testing.assert_array_equal(load("joint_elasticity").guess_scale(inputs), 1.0)
