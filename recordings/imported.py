"""The rig of measurements that were taken elsewhere: described, but not driven."""

from collections.abc import Sequence
from typing import Any

from recordings.config import validated
from recordings.errors import BadInput
from recordings.rig import JointType, MechanismName, Rig, Torque


def imported_rig(
    name: str,
    dof: int,
    rate: float,
    *,
    mechanism: MechanismName | None = None,
    joints: Sequence[JointType] = ("revolute",),
    torque: Torque | None = None,
) -> Rig:
    """The rig of measurements taken elsewhere, without drives.

    Args:
        mechanism: None for the delta robot of the paper if there are three joints, otherwise axes.
        joints: what kind each axis is, one for all or one each.
        torque: how torque follows from voltage; None: gains of 1.0, assumed.

    Raises:
        BadInput: these do not fit together.
    """
    mechanism = mechanism or ("delta" if dof == 3 else "axes")
    if mechanism == "delta" and ("prismatic" in joints or dof != 3):
        raise BadInput(
            f"{name}: three revolute joints expected for a delta robot, {dof} {joints[0]} found; choose axes"
        )
    if len(joints) not in (1, dof):
        raise BadInput(
            f"{name}: one kind of joint for all, or {dof} (one each) expected, {len(joints)} found; change the list"
        )
    types = joints if len(joints) == dof else tuple(joints) * dof
    content: dict[str, Any] = {"name": name, "mechanism": mechanism, "rate": rate}
    if mechanism == "axes":
        content["axes"] = [{"type": joint} for joint in types]
    if torque is not None:
        content["torque"] = torque.model_dump(mode="json", exclude_unset=True)
    return validated(content, Rig, name)


def measured_torque(dof: int) -> Torque:
    """For measurements that hold the effort itself, in N m or N: nothing to convert, nothing assumed."""
    return Torque(map="linear", gain=(1.0,) * dof, gain_source="calibrated", gain_uncertainty=0.0)
