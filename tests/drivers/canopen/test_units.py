import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.canopen.units import Units, units_of
from recordings.rig import AssumedUnits, Drive

DRIVE = Drive(node_id=1, counts_per_turn=8192, gear=21.0)
MOTOR = 21 / math.tau
"""Motor turns per rad of the joint."""


def acceleration(units: Units) -> float:
    assert units.problems == ()
    assert units.acceleration is not None
    return units.acceleration.per_radian


@pytest.mark.parametrize(
    ("code", "per_motor_turn"),
    [
        (0x00B55700, 8192),
        (0x00B45700, 1),
        (0x00105700, math.tau),
        (0x00415700, 360),
        (0x00C00300, 60),
        (0x00B44703, 60),
        (0xFDC00300, 60e3),
        (0xFAB45700, 1e6),
        (0x02B55700, 81.92),
    ],
)
def test_codes_of_60aa(code: int, per_motor_turn: float) -> None:
    units = units_of({(0x60AA, 0): code}, DRIVE)
    assert acceleration(units) == pytest.approx(per_motor_turn * MOTOR)


@pytest.mark.parametrize(
    ("code", "per_motor_turn", "name"),
    [
        (0x00B44700, 60, "rpm"),
        (0xFDB44700, 60e3, "0.001 rpm"),
        (0x00B50300, 8192, "counts/s"),
        (0x00100300, math.tau, "rad/s"),
    ],
)
def test_codes_of_60a9(code: int, per_motor_turn: float, name: str) -> None:
    velocity = units_of({(0x60A9, 0): code}, DRIVE).velocity
    assert velocity is not None
    assert velocity.per_radian == pytest.approx(per_motor_turn * MOTOR)
    assert velocity.name == name


def test_angles_belong_to_the_shaft_behind_the_gear_that_the_drive_knows() -> None:
    geared = {(0x6091, 1): 21, (0x6091, 2): 1}
    assert acceleration(units_of({(0x60AA, 0): 0x00105700, **geared}, DRIVE)) == pytest.approx(1.0)
    assert acceleration(units_of({(0x60AA, 0): 0x00B55700, **geared}, DRIVE)) == pytest.approx(8192 * MOTOR)


def test_older_profiles_name_units_by_dimension_and_notation_index() -> None:
    units = units_of({(0x608C, 0): 0xA4, (0x608B, 0): -3, (0x608E, 0): 0xAE, (0x608D, 0): -3}, DRIVE)
    assert units.velocity is not None
    assert units.velocity.per_radian == pytest.approx(60e3 * MOTOR)
    assert acceleration(units) == pytest.approx(1e3 * math.tau * MOTOR)


def test_increments_are_those_of_the_encoder_where_positions_are_angles() -> None:
    drive = Drive(node_id=1, counts_per_turn=360_000, gear=21.0)
    objects = {(0x60A8, 0): 0xFD410000, (0x60AA, 0): 0x00B55700, (0x608F, 1): 4096, (0x608F, 2): 1}
    assert acceleration(units_of(objects, drive)) == pytest.approx(4096 * MOTOR)


@pytest.mark.parametrize(
    ("objects", "numbers"),
    [
        ({(0x608F, 1): 4096, (0x608F, 2): 1}, ("4096", "8192")),
        ({(0x608F, 1): 8192, (0x608F, 2): 1, (0x6092, 1): 1, (0x6092, 2): 1}, ("say 1,", "8192")),
        ({(0x608F, 1): 8192, (0x608F, 2): 1, (0x6093, 1): 4, (0x6093, 2): 1}, ("2048", "8192")),
        ({(0x60A8, 0): 0x00410000}, ("360", "8192")),
        ({(0x6091, 1): 20, (0x6091, 2): 1}, ("20", "21")),
        ({(0x60A8, 0): 0x00010000}, ("60A8h = 00010000h", "unknown")),
    ],
)
def test_contradiction_with_the_rig_file_is_a_problem_with_both_numbers(
    objects: dict[tuple[int, int], int], numbers: tuple[str, str]
) -> None:
    problems = units_of(objects, DRIVE).problems
    assert problems
    assert all(number in problems[0] for number in numbers), problems


def test_factors_that_nobody_has_set_say_nothing() -> None:
    ones = {(index, sub): 1 for index in (0x608F, 0x6091, 0x6092, 0x6093, 0x6097) for sub in (1, 2)}
    units = units_of({**ones, (0x608E, 0): 0, (0x60AA, 0): 0}, DRIVE)
    assert (units.problems, units.acceleration) == ((), None)
    assert "the drive does not say it" in units.question
    consistent = {(0x608F, 1): 65536, (0x6091, 1): 21, (0x6092, 1): 8192 * 21}
    assert units_of({**ones, **consistent}, DRIVE).problems == ()


def test_rig_file_states_what_the_drive_does_not() -> None:
    drive = DRIVE.model_copy(update={"units": AssumedUnits(acceleration="0.001 rpm/s")})
    for objects in ({}, {(0x60AA, 0): 0x00123456}, {(0x6097, 1): 7, (0x6097, 2): 3}):
        assert acceleration(units_of(objects, drive)) == pytest.approx(60e3 * MOTOR)


def test_rig_file_that_contradicts_the_drive_is_a_problem_with_both_numbers() -> None:
    drive = DRIVE.model_copy(update={"units": AssumedUnits(acceleration="counts/s^2")})
    (problem,) = units_of({(0x60AA, 0): 0x00C00300}, drive).problems
    assert f"{60 * MOTOR:g} by the drive (rpm/s, 60AAh)" in problem
    assert f"{8192 * MOTOR:g} by units.acceleration" in problem


@pytest.mark.parametrize(
    ("objects", "text"),
    [
        ({(0x60AA, 0): 0x00123456}, "60AAh = 00123456h is unknown"),
        ({(0x6097, 1): 65536, (0x6097, 2): 1000}, "which it does not say"),
    ],
)
def test_unknown_unit_is_asked_of_the_rig_file(objects: dict[tuple[int, int], int], text: str) -> None:
    units = units_of(objects, DRIVE)
    assert units.acceleration is None
    assert text in units.question


@given(st.integers(-9, 9), st.sampled_from([0xB55700, 0xB45700, 0x105700, 0xC00300]), st.floats(0.5, 200))
def test_power_of_ten_and_gear_scale_exactly(exponent: int, code: int, gear: float) -> None:
    drive = DRIVE.model_copy(update={"gear": gear})
    plain = acceleration(units_of({(0x60AA, 0): code}, drive))
    scaled = acceleration(units_of({(0x60AA, 0): (exponent & 0xFF) << 24 | code}, drive))
    assert scaled * 10.0**exponent == pytest.approx(plain)
    assert plain / gear == pytest.approx(acceleration(units_of({(0x60AA, 0): code}, DRIVE)) / 21)
