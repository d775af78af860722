"""The rig of imported measurements."""

from typing import Any

import pytest

from recordings.errors import BadInput
from recordings.imported import imported_rig, measured_torque
from recordings.rig import Axis, Rig, Torque


def test_three_joints_default_to_the_delta_robot() -> None:
    rig = imported_rig("lab.csv", 3, 200.0)
    assert (rig.mechanism, rig.dof, rig.rate) == ("delta", 3, 200.0)
    assert rig.torque == Torque()
    assert imported_rig("lab.csv", 3, 200.0, mechanism="axes").joint_types == ("revolute",) * 3


def test_other_joint_counts_default_to_axes() -> None:
    rig = imported_rig("bench.csv", 2, 100.0, joints=("prismatic",), torque=Torque(map="linear"))
    assert rig.joint_types == ("prismatic", "prismatic")
    assert rig.torque.gain == (1.0, 1.0)
    assert Rig.model_validate_json(rig.model_dump_json()) == rig


def test_measured_effort_has_unit_gain() -> None:
    torque = imported_rig("axis.csv", 1, 1000.0, torque=measured_torque(1)).torque
    assert (torque.map, torque.gain, torque.gain_source, torque.gain_uncertainty) == (
        "linear",
        (1.0,),
        "calibrated",
        0,
    )


def test_gravity_loads_a_single_axis() -> None:
    assert imported_rig("axis.csv", 1, 1000.0, gravity=True).axes == (Axis(gravity=True),)


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
