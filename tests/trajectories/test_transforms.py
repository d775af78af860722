"""Transforms between the links: the closed chain closes, and another library finds the same from the URDF."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from rosbags.typesys import Stores, get_typestore

from recordings.description import description_messages, urdf_of
from recordings.rig import Rig, simulated_rig
from tests.transforms import Poses, poses, rod_errors
from trajectories.transforms import Transforms

ROS = get_typestore(Stores.ROS2_HUMBLE)
ARM = """<robot name="arm"><link name="foot"/><link name="a"/><link name="b"/><link name="tool"/>
<joint name="slide" type="prismatic"><origin xyz="0.1 0.2 0.3" rpy="0.4 -0.5 0.6"/><parent link="foot"/>
<child link="a"/><axis xyz="1 2 2"/><limit lower="-1" upper="1" effort="1" velocity="1"/></joint>
<joint name="turn" type="revolute"><origin xyz="0 0.5 0" rpy="-1 0.2 2"/><parent link="a"/><child link="b"/>
<axis xyz="0 3 4"/><limit lower="-3" upper="3" effort="1" velocity="1"/></joint>
<joint name="flange" type="fixed"><origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><parent link="b"/>
<child link="tool"/></joint>
</robot>"""
DELTA, URDF = simulated_rig(), Rig(name="arm", mechanism="urdf", urdf=ARM, joints=("turn",), fixed={"slide": 0.25})
angles = st.lists(st.floats(-0.6, 0.9), min_size=3, max_size=3)


def read_poses(rig: Rig, position: list[float]) -> Poses:
    """Poses of all links at joint positions (dof,), from the messages."""
    [(_, moving)] = Transforms(rig).messages([12_000_000_034], np.array([position]))
    fixed = description_messages(rig)["/tf_static"]
    read = [ROS.deserialize_cdr(message, "tf2_msgs/msg/TFMessage").transforms for message in (fixed, moving)]
    assert (read[1][0].header.stamp.sec, read[1][0].header.stamp.nanosec) == (12, 34)
    return poses([*read[0], *read[1]])


@given(angles)
def test_rods_have_their_length(theta: list[float]) -> None:
    assert np.abs(rod_errors(read_poses(DELTA, theta), DELTA.geometry.L2)).max() < 1e-12


@pytest.mark.parametrize(("rig", "position"), [(DELTA, [0.3, -0.4, 0.6]), (URDF, [1.2])], ids=["delta", "urdf"])
def test_pinocchio_finds_the_same_poses(rig: Rig, position: list[float]) -> None:
    pinocchio = pytest.importorskip("pinocchio")
    model = pinocchio.buildModelFromXML(urdf_of(rig))
    data, q = model.createData(), pinocchio.neutral(model)
    for name, (value,) in Transforms(rig)._joints(np.array([position])).items():
        joint = model.joints[model.getJointId(name)]
        q[joint.idx_q : joint.idx_q + joint.nq] = value if joint.nq == 1 else (np.cos(value), np.sin(value))
    pinocchio.framesForwardKinematics(model, data, q)
    for link, pose in read_poses(rig, position).items():
        found = data.oMf[model.getFrameId(link, pinocchio.FrameType.BODY)].homogeneous
        assert found == pytest.approx(pose, abs=1e-12), link


def test_gaps_and_axes_have_no_transforms() -> None:
    position = np.array([[0.1, 0.2, 0.3], [np.nan, 0.2, 0.3]])
    assert [stamp for stamp, _ in Transforms(DELTA).messages([5, 6], position)] == [5]
    axes = Rig(name="axes", mechanism="axes", axes=({"type": "revolute"},))
    assert (list(Transforms(axes).messages([5, 6], position[:, :1])), description_messages(axes)) == ([], {})
