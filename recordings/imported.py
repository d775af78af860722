"""The rig of imported measurements: described, but not driven."""

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
    gravity: bool = False,
) -> Rig:
    """Describe the rig of imported measurements, without drives.

    Args:
        mechanism: None selects the delta robot of the paper for three joints, "axes" otherwise.
        joints: type of the joints, one for all or one per joint.
        torque: torque map from voltage to torque; None: assumed gains of 1.0.
        gravity: whether gravity loads the joint of a single axis.

    Raises:
        BadInput: mechanism, number and types of joints are inconsistent.
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
    if gravity and (mechanism, dof) != ("axes", 1):
        raise BadInput(f"{name}: --gravity is for a single axis, {dof} joints found; declare it in a rig file")
    types = joints if len(joints) == dof else tuple(joints) * dof
    content: dict[str, Any] = {"name": name, "mechanism": mechanism, "rate": rate}
    if mechanism == "axes":
        content["axes"] = [{"type": joint, "gravity": gravity} for joint in types]
    if torque is not None:
        content["torque"] = torque.model_dump(mode="json", exclude_unset=True)
    return validated(content, Rig, name)


def measured_torque(dof: int, per_ampere: tuple[float, ...] = ()) -> Torque:
    """Identity torque map for measurements that contain the effort itself [N m or N], or the current [A]."""
    gain = (1.0,) * dof
    return Torque(map="linear", gain=gain, per_ampere=per_ampere, gain_source="calibrated", gain_uncertainty=0.0)
