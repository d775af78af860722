"""The rig of imported measurements."""

from typing import Any

import pytest

from recordings.errors import BadInput
from recordings.imported import imported_rig, measured_torque
from recordings.rig import Rig, Torque


def test_three_joints_are_a_delta_robot_and_others_axes_unless_said() -> None:
    rig = imported_rig("lab.csv", 3, 200.0)
    assert (rig.mechanism, rig.dof, rig.rate, rig.torque) == ("delta", 3, 200.0, Torque())
    assert imported_rig("lab.csv", 3, 200.0, mechanism="axes").joint_types == ("revolute",) * 3
    axes = imported_rig("bench.csv", 2, 100.0, joints=("prismatic",), torque=Torque(map="linear"))
    assert (axes.joint_types, axes.torque.gain) == (("prismatic", "prismatic"), (1.0, 1.0))
    assert Rig.model_validate_json(axes.model_dump_json()) == axes


@pytest.mark.parametrize(
    ("dof", "options", "reason"),
    [
        (2, {"mechanism": "delta"}, "three revolute joints expected for a delta robot, 2 revolute found"),
        (3, {"joints": ("prismatic",)}, "3 prismatic found; choose axes"),
        (3, {"mechanism": "axes", "joints": ("revolute", "prismatic")}, "one kind of joint for all, or 3"),
        (2, {"torque": Torque(gain=(1.0,))}, "torque.gain needs 2 numbers, 1 found"),
        (1, {"rate": -1.0}, "'rate'"),
        (2, {"gravity": True}, "--gravity is for a single axis, 2 joints found"),
        (2, {"torque": measured_torque(2, (0.1,))}, "torque.per_ampere: none or 2 expected, 1 found"),
    ],
)
def test_inconsistent_options_are_refused(dof: int, options: dict[str, Any], reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        imported_rig("x.csv", dof, **{"rate": 100.0} | options)
