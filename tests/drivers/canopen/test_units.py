import math

import pytest

from drivers.canopen.units import Units, position_units_per_turn
from recordings.rig import AssumedUnits, Drive

DRIVE = Drive(node_id=1, counts_per_turn=8192, gear=21.0)
MOTOR = 21 / math.tau
"""Motor turns per rad of the joint."""


GEARED = {(0x6091, 1): 21, (0x6091, 2): 1}


def acceleration(units: Units) -> float:
    assert units.problems == []
    assert units.acceleration is not None
    return units.acceleration.per_radian


@pytest.mark.parametrize(
    ("objects", "expected"),
    [
        ({(0x60AA, 0): 0x00B55700}, 8192 * MOTOR),
        ({(0x60AA, 0): 0x00B45700}, MOTOR),
        ({(0x60AA, 0): 0x00105700}, math.tau * MOTOR),
        ({(0x60AA, 0): 0x00415700}, 360 * MOTOR),
        ({(0x60AA, 0): 0x00C00300}, 60 * MOTOR),
        ({(0x60AA, 0): 0x00B44703}, 60 * MOTOR),
        ({(0x60AA, 0): 0xFDC00300}, 60e3 * MOTOR),
        ({(0x60AA, 0): 0xFAB45700}, 1e6 * MOTOR),
        ({(0x60AA, 0): 0x02B55700}, 81.92 * MOTOR),
        # Angles belong to the shaft behind the gear that the drive knows, increments to the motor.
        ({(0x60AA, 0): 0x00105700, **GEARED}, 1.0),
        ({(0x60AA, 0): 0x00B55700, **GEARED}, 8192 * MOTOR),
        # Older profiles name units by dimension and notation index.
        ({(0x608E, 0): 0xAE, (0x608D, 0): -3}, 1e3 * math.tau * MOTOR),
    ],
)
def test_unit_of_acceleration(objects: dict[tuple[int, int], int], expected: float) -> None:
    assert acceleration(Units(objects, DRIVE)) == pytest.approx(expected)


@pytest.mark.parametrize(
    ("objects", "per_motor_turn", "name"),
    [
        ({(0x60A9, 0): 0x00B44700}, 60, "rpm"),
        ({(0x60A9, 0): 0xFDB44700}, 60e3, "0.001 rpm"),
        ({(0x60A9, 0): 0x00B50300}, 8192, "counts/s"),
        ({(0x60A9, 0): 0x00100300}, math.tau, "rad/s"),
        ({(0x608C, 0): 0xA4, (0x608B, 0): -3}, 60e3, "0.001 rpm"),
    ],
)
def test_unit_of_velocity(objects: dict[tuple[int, int], int], per_motor_turn: float, name: str) -> None:
    velocity = Units(objects, DRIVE).velocity
    assert velocity is not None
    assert velocity.per_radian == pytest.approx(per_motor_turn * MOTOR)
    assert velocity.name == name


def test_increments_are_those_of_the_encoder_where_positions_are_angles() -> None:
    drive = Drive(node_id=1, counts_per_turn=360_000, gear=21.0)
    objects = {(0x60A8, 0): 0xFD410000, (0x60AA, 0): 0x00B55700, (0x608F, 1): 4096, (0x608F, 2): 1}
    assert acceleration(Units(objects, drive)) == pytest.approx(4096 * MOTOR)


@pytest.mark.parametrize(
    ("objects", "numbers"),
    [
        ({(0x608F, 1): 4096, (0x608F, 2): 1}, ("4096", "8192")),
        ({(0x608F, 1): 4096, (0x608F, 2): 1, (0x6092, 1): 1, (0x6092, 2): 1}, ("4096", "8192")),
        ({(0x608F, 1): 8192, (0x608F, 2): 1, (0x6093, 1): 4, (0x6093, 2): 1}, ("2048", "8192")),
        ({(0x60A8, 0): 0x00410000}, ("360", "8192")),
        ({(0x6091, 1): 20, (0x6091, 2): 1}, ("20", "21")),
        ({(0x60A8, 0): 0x00010000}, ("60A8h = 00010000h", "unknown")),
    ],
)
def test_contradiction_with_the_rig_file_is_a_problem_with_both_numbers(
    objects: dict[tuple[int, int], int], numbers: tuple[str, str]
) -> None:
    problems = Units(objects, DRIVE).problems
    assert problems
    assert all(number in problems[0] for number in numbers), problems


@pytest.mark.parametrize("counts", [2000, 1])
@pytest.mark.parametrize("further", [{}, {(0x60A8, 0): 0x00B50000}, {(0x6091, 1): 1, (0x6091, 2): 1}])
def test_a_feed_of_1_beside_a_resolution_leaves_both_readings(
    counts: int, further: dict[tuple[int, int], int]
) -> None:
    objects = {(0x608F, 1): 2000, (0x608F, 2): 1, (0x6092, 1): 1, (0x6092, 2): 1}
    units = Units(objects | further, DRIVE.model_copy(update={"counts_per_turn": counts}))
    assert units.problems == []
    assert units.readings == {"608Fh": 2000, "6092h and 6091h": 1}
    assert next(iter(position_units_per_turn(objects | further))) == "608Fh"


def test_factors_that_nobody_has_set_say_nothing() -> None:
    ones = {(index, sub): 1 for index in (0x608F, 0x6091, 0x6092, 0x6093, 0x6097) for sub in (1, 2)}
    units = Units({**ones, (0x608E, 0): 0, (0x60AA, 0): 0}, DRIVE)
    assert not units.readings
    assert (units.problems, units.acceleration) == ([], None)
    assert "the drive does not say it" in units.question
    consistent = {(0x608F, 1): 65536, (0x6091, 1): 21, (0x6092, 1): 8192 * 21}
    assert Units({**ones, **consistent}, DRIVE).problems == []


def test_rig_file_states_what_the_drive_does_not() -> None:
    drive = DRIVE.model_copy(update={"units": AssumedUnits(acceleration="0.001 rpm/s")})
    for objects in ({}, {(0x60AA, 0): 0x00123456}, {(0x6097, 1): 7, (0x6097, 2): 3}):
        assert acceleration(Units(objects, drive)) == pytest.approx(60e3 * MOTOR)


def test_rig_file_that_contradicts_the_drive_is_a_problem_with_both_numbers() -> None:
    drive = DRIVE.model_copy(update={"units": AssumedUnits(acceleration="counts/s^2")})
    (problem,) = Units({(0x60AA, 0): 0x00C00300}, drive).problems
    assert f"{60 * MOTOR:g} by the drive (rpm/s, 60AAh)" in problem
    assert f"{8192 * MOTOR:g} by units.acceleration" in problem


@pytest.mark.parametrize(
    ("objects", "text"),
    [
        ({(0x60AA, 0): 0x00123456}, "60AAh = 00123456h is unknown"),
        ({(0x6097, 1): 65536, (0x6097, 2): 1000}, "which it does not say"),
        ({(0x60A9, 0): 0x00B44700}, "60A9h says rpm for speeds, nothing says the unit of accelerations"),
        ({(0x608E, 0): 0xA4}, "608Eh = A4h (rpm, a unit of speed)"),
    ],
)
def test_unknown_unit_is_asked_of_the_rig_file(objects: dict[tuple[int, int], int], text: str) -> None:
    units = Units(objects, DRIVE)
    assert units.acceleration is None
    assert text in units.question
