"""MuJoCo's inverse dynamics of the exported robot is the model's, in a motion that keeps the chain closed."""

from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import ident
from ident.export import exporting, paths
from ident.identification.model import Model, rig_of
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, Geometry
from tests.ident.export.models import model_with
from tests.ident.kept_models import MODELS
from trajectories import kinematics

PASSIVE = (
    "elbow_1", "swing_1", "elbow_2", "swing_2", "elbow_3", "swing_3", "platform_x", "platform_y", "platform_z",
)  # fmt: skip
CARRIED = ("rod_inertia", "arm_com_offset", "arm_mass_mismatch", "joint_spring", "base_tilt", "geometry_error")
H = 1e-4


def passive(geometry: Geometry, q: Floats) -> Floats:
    """Coordinates (n, 9) of forearms and platform that close the chain at the joint angles `q` (n, 3)."""
    P, level = kinematics.forward(geometry, q), kinematics.forward(geometry, np.zeros((1, 3)))[0]
    out = geometry.R - geometry.r
    begin = np.arctan2(level[2], -(out + geometry.L1))
    angles = []
    for limb, phi in enumerate(geometry.phi):
        x = P[:, 0] * np.cos(phi) + P[:, 1] * np.sin(phi) - out - geometry.L1 * np.cos(q[:, limb])
        y = -P[:, 0] * np.sin(phi) + P[:, 1] * np.cos(phi)
        elbow = np.arctan2(P[:, 2] - geometry.L1 * np.sin(q[:, limb]), x) - q[:, limb] - begin
        angles += [np.angle(np.exp(1j * elbow)), np.arcsin(y / geometry.L2)]
    return np.column_stack([*angles, P - level])


def slopes(geometry: Geometry, q: Floats) -> Floats:
    """Derivatives (n, 9, 3) of `passive`."""
    return np.stack(
        [(passive(geometry, q + H * e) - passive(geometry, q - H * e)) / (2 * H) for e in np.eye(3)], axis=2
    )


def inverse(path: Path, geometry: Geometry, q: Floats, qd: Floats, qdd: Floats, dry: bool) -> Floats:
    """Torque (n, 3) of the actuated joints: generalised forces without the connections, projected on them."""
    robot = mujoco.MjModel.from_xml_path(str(path))
    robot.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_EQUALITY
    if not dry:
        robot.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    data = mujoco.MjData(robot)
    B = slopes(geometry, q)
    B_dot = (slopes(geometry, q + H * qd) - slopes(geometry, q - H * qd)) / (2 * H)
    position = passive(geometry, q)
    velocity = np.einsum("nij,nj->ni", B, qd)
    acceleration = np.einsum("nij,nj->ni", B, qdd) + np.einsum("nij,nj->ni", B_dot, qd)
    active = [robot.joint(f"joint_{joint}").qposadr[0] for joint in (1, 2, 3)]
    others = [robot.joint(name).qposadr[0] for name in PASSIVE]
    torque = np.empty_like(q)
    for k in range(len(q)):
        data.qpos[active], data.qpos[others] = q[k] + robot.qpos0[active], position[k]
        data.qvel[active], data.qvel[others] = qd[k], velocity[k]
        data.qacc[active], data.qacc[others] = qdd[k], acceleration[k]
        mujoco.mj_inverse(robot, data)
        torque[k] = data.qfrc_inverse[active] + B[k].T @ data.qfrc_inverse[others]
    for limb in (1, 2, 3):
        np.testing.assert_allclose(data.site(f"rod_{limb}").xpos, data.site(f"platform_{limb}").xpos, atol=1e-9)
    return torque


def exported(model: Model, folder: Path) -> mujoco.MjModel:
    """The robot as MuJoCo reads it."""
    path = paths.from_trajectory("fig5a", rig_of(model.file), 1, 100.0)
    exporting.export(model, "mjcf", folder / "robot.xml", path)
    return mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))


def difference(model: Model, name: str, out: Path, dry: bool) -> Floats:
    """RMS difference (3,) from the model's torque along a trajectory, over the RMS of that torque."""
    path = paths.from_trajectory(name, rig_of(model.file), 1, 250.0)
    carried = exporting.export(model, "mjcf", out, path)
    assert not carried.lost
    motion = (path.motion.position, path.motion.velocity, path.motion.acceleration)
    rig, corrections = model.dynamics.structure.corrections(model.dynamics.values, rig_of(model.file))
    q = motion[0]
    for correct in corrections:
        q = correct(q)
    expected = model.torque(*motion) - (0 if dry else model.terms(*motion)["coulomb"])
    excess = inverse(out, rig.geometry, q, *motion[1:], dry) - expected
    rms: Floats = np.sqrt((excess**2).mean(axis=0) / (expected**2).mean(axis=0))
    return rms


@pytest.mark.parametrize("name", ["fig5a", "fig5b"])
def test_inverse_dynamics_are_those_of_the_model(name: str, tmp_path: Path) -> None:
    model = ident.load_model(MODELS / "diagnosed.model.json")
    assert (difference(model, name, tmp_path / "robot.xml", dry=False) < 1e-5).all()
    assert (difference(model, name, tmp_path / "robot.xml", dry=True) < 5e-3).all()


@pytest.mark.parametrize("name", [*CARRIED, "encoder_zero_offset"])
def test_every_carried_effect_is_in_the_inverse_dynamics(name: str, tmp_path: Path) -> None:
    model = model_with([name])
    assert (difference(model, "fig5b", tmp_path / "robot.xml", dry=False) < 1e-3).all()


def test_the_robot_hangs_together_in_a_simulation(tmp_path: Path) -> None:
    model = ident.load_model(MODELS / "diagnosed.model.json")
    robot = exported(model, tmp_path)
    data = mujoco.MjData(robot)
    torque = model.torque(*np.zeros((3, 1, 3)))[0]
    for _ in range(500):
        data.ctrl[:] = torque
        mujoco.mj_step(robot, data)
    for limb in (1, 2, 3):
        gap = np.linalg.norm(data.site(f"rod_{limb}").xpos - data.site(f"platform_{limb}").xpos)
        assert gap < 1e-3
    assert np.abs(data.qpos).max() < 0.02  # the model's own torque holds it
    assert robot.actuator_gear.shape[0] == 3


@pytest.mark.parametrize("names", [(), ("encoder_zero_offset", "base_tilt", "joint_spring")])
def test_the_key_frame_holds_the_arms_level_within_the_limits_of_the_rig(
    names: tuple[str, ...], tmp_path: Path
) -> None:
    model = model_with(["rod_inertia", *names])
    robot = exported(model, tmp_path)
    data = mujoco.MjData(robot)
    mujoco.mj_resetDataKeyframe(robot, data, robot.key("level").id)
    start = data.qpos.copy()
    for _ in range(500):
        mujoco.mj_step(robot, data)
    assert np.abs(data.qpos - start).max() < 0.002
    np.testing.assert_array_equal(robot.actuator_ctrlrange, [[-60.0, 60.0]] * 3)
    for joint in (1, 2, 3):
        np.testing.assert_array_equal(robot.joint(f"joint_{joint}").range, [-1.2, 1.4])


def test_bodies_are_physically_consistent(tmp_path: Path) -> None:
    robot = exported(model_with(CARRIED), tmp_path)
    moments = np.sort(robot.body_inertia[1:], axis=1)
    assert (robot.body_mass[1:] > 0).all()
    assert (moments > 0).all()
    assert (moments[:, 0] + moments[:, 1] >= moments[:, 2]).all()
    assert (robot.dof_armature >= 0).all()


def test_friction_that_drives_is_lost_and_other_mechanisms_are_refused(tmp_path: Path) -> None:
    model = model_with(["stribeck"])
    viscous = [entry for entry in model.file.parameters if entry.name.startswith("c_v")]
    worse = {entry.name: entry.model_copy(update={"value": -1.0}) for entry in viscous}
    parameters = tuple(worse.get(entry.name, entry) for entry in model.file.parameters)
    driven = Model(model.file.model_copy(update={"parameters": parameters}), model.library)
    path = paths.from_trajectory("fig5a", rig_of(model.file), 1, 100.0)
    carried = exporting.export(driven, "mjcf", tmp_path / "robot.xml", path)
    assert set(carried.lost) == {"stribeck", "viscous"}
    swing = replace(path, motion=paths.Motion(*np.zeros((4, len(path.time), 1))))
    with pytest.raises(BadInput, match="'delta' or 'urdf' expected for MJCF"):
        exporting.export(model_with([], [Axis()]), "mjcf", tmp_path / "axis.xml", swing)
