"""Exported arms: bodies that can be, and the model's torque, in Pinocchio and in MuJoCo."""

import json
from pathlib import Path

import mujoco
import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.bodies import link_parameters, pseudo_inertia
from ident.dynamics.motion import Motion
from ident.export import exporting
from ident.export.arms.bodies import arm_of
from ident.export.paths import GivenPath
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from tests.ident.dynamics.loops import four_bar_keys, mimicking, rig
from tests.ident.export.arms import arm_model, arm_path
from tests.ident.export.models import model_of, model_with
from tests.ident.identification.test_urdf_robot import COULOMB, OFFSET, URDF, VISCOUS

pinocchio = pytest.importorskip("pinocchio")


def rigid(model: Model) -> Floats:
    """Torque (n, 3) of the model without friction and constant torque."""
    at = arm_path().motion
    parts = model.terms(at.position, at.velocity, at.acceleration)
    return sum(parts.values(), start=np.zeros((1, 3))) - parts["viscous"] - parts["coulomb"] - OFFSET


def inverse(robot: mujoco.MjModel, at: Motion) -> Floats:
    """MuJoCo's inverse dynamics (n, dof) along a motion, without dry friction."""
    robot.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS
    data = mujoco.MjData(robot)
    torque = np.empty_like(at.position)
    for k in range(len(torque)):
        data.qpos[:], data.qvel[:], data.qacc[:] = at.position[k], at.velocity[k], at.acceleration[k]
        mujoco.mj_inverse(robot, data)
        torque[k] = data.qfrc_inverse
    return torque


def share(difference: Floats, model: Model) -> Floats:
    """RMS (3,) of a torque over the model's held-out error."""
    error = (model.file.validate_ or model.file.train).fitted.rms
    rms: Floats = np.sqrt(np.mean(difference**2, axis=0)) / error
    return rms


def test_pseudo_inertia_has_the_parameters_of_its_link() -> None:
    parameters = np.random.default_rng(0).normal(size=(5, 10))
    np.testing.assert_allclose(link_parameters(pseudo_inertia(parameters)), parameters, atol=1e-14)


@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_every_link_is_a_body_and_the_torque_is_the_models(noise: float, tmp_path: Path) -> None:
    model, out = arm_model(noise=noise), tmp_path / "robot.urdf"
    carried = exporting.export(model, "urdf", out, arm_path())
    assert set(carried.carried) == {"links", "viscous", "coulomb", "motor_inertia"}
    document = json.loads((tmp_path / "robot.urdf.carried.json").read_text())
    assert [each["effect"] for each in document["not_carried"]] == ["constant_torque"]
    np.testing.assert_allclose(document["torque_lost_rms"], np.abs(OFFSET), rtol=0.02)
    arm = arm_of(model, arm_path())
    assert (np.linalg.eigvalsh(pseudo_inertia(arm.links)) > 0).all()
    assert (arm.motors >= 0).all()
    robot = pinocchio.buildModelFromUrdf(str(out))
    data, at = robot.createData(), arm_path().motion
    angle = at.position[:, 0]
    full = np.column_stack(
        [np.cos(angle), np.sin(angle), at.position[:, 1:]]
    )  # a continuous joint has two coordinates
    signals = zip(full, at.velocity, at.acceleration, strict=True)
    links = np.array([pinocchio.rnea(robot, data, *signal) for signal in signals])
    assert (share(links + arm.motors * at.acceleration - rigid(model), model) < 0.2).all()
    in_mujoco = mujoco.MjModel.from_xml_path(str(out))
    np.testing.assert_allclose(inverse(in_mujoco, at), links + VISCOUS * at.velocity, atol=1e-6 * np.abs(links).max())


@pytest.mark.parametrize("names", [(), ("base_tilt",), ("joint_spring",), ("encoder_zero_offset",)])
def test_mujoco_has_the_torque_of_the_model(names: tuple[str, ...], tmp_path: Path) -> None:
    model, out = arm_model(names), tmp_path / "robot.xml"
    assert set(exporting.export(model, "mjcf", out, arm_path()).lost) == {"constant_torque"}
    robot = mujoco.MjModel.from_xml_path(str(out))
    difference = inverse(robot, arm_path().motion) - VISCOUS * arm_path().motion.velocity - rigid(model)
    assert (share(difference, model) < 0.2).all()
    np.testing.assert_allclose(robot.dof_frictionloss, COULOMB)


def test_other_joints_stand_where_they_are_fixed(tmp_path: Path) -> None:
    """Whether a finger is fixed where it stands by the rig file, or by the exported URDF."""
    limit = '<limit lower="-1" upper="1" effort="1" velocity="1"/>'
    finger = f"""<link name="tip"/><joint name="finger" type="revolute"><parent link="l3"/><child link="tip"/>
        <origin xyz="0.1 0 0" rpy="0.2 0 0.1"/><axis xyz="0 1 0"/>{limit}</joint><link name="nail"/>
        <joint name="reach" type="prismatic"><parent link="tip"/><child link="nail"/>
        <axis xyz="0 0 1"/>{limit}</joint>"""
    model = arm_model(urdf=URDF.replace("</robot>", finger + "</robot>"), fixed={"finger": 0.3, "reach": 0.2})
    out = tmp_path / "robot.urdf"
    exporting.export(model, "urdf", out, arm_path())
    robot = pinocchio.buildModelFromUrdf(str(out))
    assert robot.nv == 3
    moved = pinocchio.buildModelFromXML(model.file.robot.urdf)  # type: ignore[union-attr]
    position = pinocchio.neutral(moved)
    position[-2:] = 0.3, 0.2
    places = []
    for each, q in ((robot, pinocchio.neutral(robot)), (moved, position)):
        data = each.createData()
        pinocchio.framesForwardKinematics(each, data, q)
        places.append(data.oMf[each.getFrameId("nail")].homogeneous)
    np.testing.assert_allclose(*places, atol=1e-12)


def test_what_has_no_element_is_lost_and_other_mechanisms_are_refused(tmp_path: Path) -> None:
    coupled = arm_model(["base_tilt", "stribeck"], couplings=({"of": 3, "by": 2},))
    carried = exporting.export(coupled, "urdf", tmp_path / "robot.urdf", arm_path())
    assert set(carried.lost) == {"base_tilt", "stribeck", "viscous", "coulomb", "constant_torque", "motor_inertia"}
    with pytest.raises(BadInput, match="mechanism 'urdf' expected, 'delta' found"):
        exporting.export(model_with([]), "urdf", tmp_path / "delta.urdf", arm_path())


@pytest.mark.parametrize(
    ("robot", "found"),
    [
        (rig(four_bar_keys()), "closed loops"),
        (
            rig({"urdf": mimicking(four_bar_keys()["urdf"], elbow=("drive", -1.0, 0.0)), "joints": ("drive",)}),
            "joints that mimic others",
        ),
    ],
)
@pytest.mark.parametrize("target", ["urdf", "mjcf", "c", "fmu"])
def test_joints_that_follow_others_are_refused(robot: Rig, found: str, target: str, tmp_path: Path) -> None:
    model = model_of(robot, np.ones(len(mechanisms.create(robot).parameters)), [])
    still = np.zeros((20, 1))
    path = GivenPath("still", 100.0, np.arange(20) / 100, Motion(still, still, still, still))
    with pytest.raises(BadInput, match=f"a tree of links expected, {found} found, which this export cannot carry"):
        exporting.export(model, target, tmp_path / "out", path)
    assert not list(tmp_path.iterdir())
