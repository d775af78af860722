import pytest

from drivers.canopen import readiness
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from recordings.rig import Drive


def dictionary(drive: Drive, *absent: int, **values: int) -> DriveDictionary:
    """Standard dictionary without some objects, with values such as x6502=0x80 (4 bytes)."""
    data = {address: value for address, value in standard_dictionary(drive).data.items() if address[0] not in absent}
    data[0x6502, 0] = (0xC0).to_bytes(4, "little")
    data |= {(int(name[1:], 16), 0): value.to_bytes(4, "little") for name, value in values.items()}
    return DriveDictionary(drive, data)


def test_complete_drive_is_ready() -> None:
    assert readiness.problems(dictionary(Drive(node_id=1))) == []


@pytest.mark.parametrize("index", [0x6065, 0x6066, 0x607D, 0x605A, 0x605D, 0x605E, 0x6007, 0x6085])
def test_missing_object_of_safety_is_named_with_its_loss_until_it_is_accepted(index: int) -> None:
    (problem,) = readiness.problems(dictionary(Drive(node_id=1), index))
    assert problem.startswith(f"{index:04X}h")
    assert f'accept_missing = ["{index:04X}"]' in problem
    accepted = Drive(node_id=1, accept_missing=(f"{index:04X}",))
    assert readiness.problems(dictionary(accepted, index)) == []
    assert readiness.missing_for_safety(dictionary(accepted, index)) == [index]


def test_watchdog_is_missing_only_where_no_other_one_is_there() -> None:
    drive = Drive(node_id=1)
    assert readiness.problems(dictionary(drive, 0x1016)) == []  # guarding
    (problem,) = readiness.problems(dictionary(drive, 0x1016, 0x100D))
    assert "does not stop when this program or the cable fails" in problem


def test_torque_offset_needs_its_object_and_the_rated_torque_of_the_drive() -> None:
    drive = Drive(node_id=1, torque_offset=True, rated_torque=21.0, gear=21.0)
    assert readiness.problems(dictionary(drive)) == []
    assert readiness.problems(dictionary(drive, x6076=1005)) == []
    (problem,) = readiness.problems(dictionary(drive, 0x60B2))
    assert problem.startswith("60B2:00 torque offset: no such object")
    (problem,) = readiness.problems(dictionary(drive, x6076=1500))
    assert "6076h of the drive gives 31.5 N m" in problem
    assert "rated_torque of the rig file is 21 N m" in problem
    unused = drive.model_copy(update={"torque_offset": False})
    assert readiness.problems(dictionary(unused, 0x60B2, x6076=1500)) == []


@pytest.mark.parametrize("index", [0x6041, 0x6060, 0x6064, 0x607A])
def test_object_of_motion_cannot_be_accepted_as_missing(index: int) -> None:
    drive = Drive(node_id=1, accept_missing=(f"{index:04X}",))
    assert any("no such object" in problem for problem in readiness.problems(dictionary(drive, index)))


@pytest.mark.parametrize("index", [0x1006, 0x1017, 0x603F, 0x6061])
def test_objects_of_convenience_may_be_missing(index: int) -> None:
    assert readiness.problems(dictionary(Drive(node_id=1), index)) == []


@pytest.mark.parametrize(
    ("modes", "assumed", "text"),
    [
        (0x80, False, None),
        (0x40, True, 'mode = "interpolated" is there'),
        (0x25, True, "neither mode 7 nor 8"),
        (0, False, "6502h is 0"),
        (0, True, None),
    ],
)
def test_mode_is_listed_or_assumed(modes: int, assumed: bool, text: str | None) -> None:
    problem = readiness.mode_problem(dictionary(Drive(node_id=1, assume_mode=assumed), x6502=modes))
    assert (problem is None) if text is None else text in str(problem)


def test_unit_is_asked_only_where_a_ramp_is_written() -> None:
    drive = Drive(node_id=1, accept_missing=("6085",))
    assert any("unit of acceleration" in text for text in readiness.problems(dictionary(drive, 0x60AA)))
    assert readiness.problems(dictionary(drive, 0x60AA, 0x6085, 0x6084)) == []
