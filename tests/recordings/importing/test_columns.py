"""What columns are taken for, from names, units and values."""

from pathlib import Path

import numpy as np
import pytest

from recordings.importing import columns as module
from recordings.importing.table import Table
from recordings.importing.units import in_name

N = 400
TIME = np.arange(N) * 0.004
ANGLE = np.sin(TIME)
SPEED = np.cos(TIME)


def table_of(columns: dict[str, np.ndarray], units: dict[str, str] | None = None) -> Table:
    return Table(Path("data.csv"), columns, units or {})


def taken(table: Table) -> dict[str, str]:
    """Quantity and unit by column."""
    return {
        guess.column: f"{guess.target} {guess.source.unit.text}".strip()
        for guess in module.guess(table)
        if guess.target and guess.source
    }


@pytest.mark.parametrize(
    ("names", "expected"),
    [
        (("t", "q1", "q2", "tau1", "tau2"),
         ("time s", "position_1 rad", "position_2 rad", "effort_1 Nm", "effort_2 Nm")),
        (("Zeit", "Winkel A2", "Winkel A1", "Strom A2", "Strom A1"),
         ("time s", "position_2 rad", "position_1 rad", "current_2 A", "current_1 A")),
        (("time", "left_pos", "right_pos", "left_cur", "right_cur"),
         ("time", "position_1 rad", "position_2 rad", "current_1 A", "current_2 A")),
        (("timestamp", "GVL.Axis[1].ActPos", "GVL.Axis[2].ActPos", "GVL.Axis[1].ActTorque", "GVL.Axis[2].ActTorque"),
         ("time s", "position_1 rad", "position_2 rad", "effort_1 Nm", "effort_2 Nm")),
        (("t", "q[0]", "q[1]", "u[0]", "u[1]"),
         ("time s", "position_1 rad", "position_2 rad", "voltage_1 V", "voltage_2 V")),
        (("t", "left_pos", "right_pos", "right_torque", "left_torque"),
         ("time s", "position_1 rad", "position_2 rad", "effort_2 Nm", "effort_1 Nm")),
        (("t", "elbow_pos", "wrist_1_pos", "elbow_tau", "wrist_1_tau"),
         ("time s", "position_1 rad", "position_2 rad", "effort_1 Nm", "effort_2 Nm")),
    ],
)  # fmt: skip
def test_names_of_many_programs(names: tuple[str, ...], expected: tuple[str, ...]) -> None:
    table = table_of(dict(zip(names, (TIME, ANGLE, ANGLE, SPEED, SPEED), strict=True)))
    assert taken(table) == dict(zip(names, expected, strict=True))


@pytest.mark.parametrize(
    "name",
    [
        *("Torque mNm", "Torque in mNm", "Torque: mNm", "Torque - mNm", "Torque|mNm", "Torque <mNm>", "Torque {mNm}"),
        *("[mNm] Torque", "torque_mNm", "Torque/mNm", "mNm Torque [mNm]"),
    ],
)
def test_units_are_read_wherever_they_stand_in_a_name(name: str) -> None:
    assert taken(table_of({"t": TIME, "q": ANGLE, name: SPEED}))[name] == "effort_1 mNm"


@pytest.mark.parametrize(
    ("name", "unit"),
    [
        ("Torque/%", "%"), ("Torque percent", "percent"), ("torque 0.1%", "0.1%"), ("Torque oz-in", "oz-in"),
        ("Position turns", "turns"), ("speed rad/s", "rad/s"), ("Torque/N", "N"), ("Torque in N", "N"),
        ("Torque A", ""), ("torque_N", ""), ("joint 2 angle", ""), ("axis 2 deg", "deg"), ("t_min", ""),
    ],
)  # fmt: skip
def test_letters_and_numbers_of_joints_are_no_units(name: str, unit: str) -> None:
    found = in_name(name)
    assert (found.text if found else "") == unit


@pytest.mark.parametrize(("scale", "unit"), [(1.0, "s"), (1e3, "ms"), (1e6, "us"), (1e9, "ns")])
def test_rate_tells_the_unit_of_time(scale: float, unit: str) -> None:
    assert taken(table_of({"t": TIME * scale, "q": ANGLE, "i": SPEED}))["t"] == f"time {unit}"


@pytest.mark.parametrize(
    ("column", "values", "unit"),
    [
        ("q", 90 * ANGLE, "position_1 deg"),
        ("q", np.rint(50_000 * ANGLE), "position_1 counts"),
        ("q", ANGLE, "position_1 rad"),
        ("q_deg", ANGLE, "position_2 deg"),
        ("q", np.full(N, np.nan), None),
        ("i", 900 * SPEED, "current_1 mA"),
        ("position_1", ANGLE, "position_1"),
    ],
)
def test_range_tells_the_unit_of_angles(column: str, values: np.ndarray, unit: str | None) -> None:
    assert taken(table_of({"t": TIME, "q": ANGLE, "i": SPEED, column: values})).get(column) == unit


@pytest.mark.parametrize(("factor", "unit"), [(1.0, "rad/s"), (180 / np.pi, "deg/s"), (60 / 2 / np.pi, "rpm")])
def test_derivative_of_the_position_tells_the_unit_of_velocity(factor: float, unit: str) -> None:
    table = table_of({"t": TIME, "q": ANGLE, "speed": factor * SPEED, "tau": ANGLE})
    assert taken(table)["speed"] == f"velocity_1 {unit}"


def test_units_of_the_file_go_before_names() -> None:
    table = table_of({"t": TIME, "channel 1": ANGLE, "channel 2": SPEED}, {"channel 1": "deg", "channel 2": "A"})
    assert taken(table) == {"t": "time s", "channel 1": "position_1 deg", "channel 2": "current_1 A"}


def test_references_errors_and_supplies_are_no_measurements() -> None:
    columns = {
        "t": TIME,
        "q": ANGLE,
        "q_ref": ANGLE,
        "q_error": ANGLE,
        "tau_ref": SPEED,
        "dc_link_voltage": SPEED,
        "tau": SPEED,
    }
    table = table_of(columns)
    assert taken(table) == {"t": "time s", "q": "position_1 rad", "q_ref": "command_1 rad", "tau": "effort_1 Nm"}


def test_values_that_no_joint_has_stop_no_guess() -> None:
    columns = {"t": TIME.copy(), "q": ANGLE.copy(), "qd": SPEED.copy(), "tau": SPEED.copy()}
    for values in columns.values():
        values[-1] = 1e300
    quantities = [text.split()[0] for text in taken(table_of(columns)).values()]
    assert quantities == ["time", "position_1", "velocity_1", "effort_1"]


def test_a_time_that_stands_twice_is_the_time_all_the_same() -> None:
    twice = TIME.copy()
    twice[300] = twice[299]
    assert taken(table_of({"Zeit": twice, "row": np.arange(N), "q": ANGLE, "i": SPEED}))["Zeit"] == "time s"


def test_a_column_that_spoils_its_group_is_named() -> None:
    columns = {"t": TIME, "q1": ANGLE, "q2": ANGLE, "tau2": SPEED}
    table = Table(Path("data.csv"), columns, {}, invalid={"tau1": "line 3: a number expected, '---' found"})
    why = {guess.column: guess.why for guess in module.guess(table)}
    assert "'---' found" in why["tau1"]
    assert why["tau2"] == "effort: another is taken, or joints lack it"
