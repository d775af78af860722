"""Recordings of simulated arms of a URDF: the torque by Pinocchio's own inverse dynamics, with friction and noise."""

import re
from collections.abc import Sequence

import numpy as np
import pinocchio

import ident
from recordings.recording import Floats
from recordings.rig import Rig
from tests.ident.identification.test_urdf_robot import motion

LIFTING, SHOULDER = ("0 1 0", "0 1 0"), ("0 0 1", "0 1 0", "0 1 0")
"""Axes of arms of revolute joints."""


def urdf(axes: Sequence[str], *, centre: str = "0.2 0.01 0.05", limits: str = "-2 2", length: float = 0.4) -> str:
    """An arm of revolute joints about `axes`, whose links have their centres of mass at `centre`."""
    low, high = limits.split()
    links = "".join(
        f'<link name="l{i}"><inertial><origin xyz="{centre}"/><mass value="2"/>'
        '<inertia ixx="0.02" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>'
        for i in range(1, len(axes) + 1)
    )
    joints = "".join(
        f'<joint name="j{i + 1}" type="revolute"><parent link="l{i}"/><child link="l{i + 1}"/>'
        f'<origin xyz="{length if i else 0} 0 0"/><axis xyz="{axis}"/>'
        f'<limit lower="{low}" upper="{high}" effort="100" velocity="5"/></joint>'
        for i, axis in enumerate(axes)
    )
    return f'<robot name="arm"><link name="l0"/>{links}{joints}</robot>'


def without_masses(text: str) -> str:
    """The same robot of which lengths alone are known."""
    return re.sub("<inertial>.*?</inertial>", "", text)


def rig(text: str) -> Rig:
    """Describe the arm of a URDF."""
    return Rig(name="arm", mechanism="urdf", urdf=text, joints=tuple(re.findall('<joint name="(.*?)"', text)))


def record(
    true: str,
    told: str | None = None,
    *,
    seed: int = 1,
    weight: float = 1.0,
    gain: Floats | float = 1.0,
    scale: float = 1.0,
) -> ident.Recording:
    """A motion of the arm `true`, which the rig file says to be `told`.

    weight: share of it that the torque holds; gain: of the torque of each joint; scale: of the reported positions.
    """
    model = pinocchio.buildModelFromXML(true)
    data = model.createData()
    time, *motions = motion(seed)
    q, v, a = (signal[:, : model.nq] for signal in motions)
    effort = np.array([pinocchio.rnea(model, data, *at) for at in zip(q, v, a, strict=True)])
    gravity = np.array([pinocchio.computeGeneralizedGravity(model, data, at).copy() for at in q])
    effort = (effort - (1 - weight) * gravity + 0.5 * v + 0.6 * np.sign(v)) * gain
    effort += np.random.default_rng(seed).normal(0, 0.02, effort.shape) * effort.std(axis=0)
    q = scale * np.round(q / 1e-5) * 1e-5
    return ident.Recording.from_arrays(time, q, effort=effort, rig=rig(told or true))
