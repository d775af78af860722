import pytest

from drivers.canopen import readiness
from drivers.eds import Address
from recordings.rig import Drive, simulated_rig
from tests.drivers.canopen.given import dictionary

RIG = simulated_rig()


def problems(drive: Drive, *absent: int | Address, values: dict[Address, int] | None = None) -> list[str]:
    return readiness.problems(RIG, dictionary(drive, {(0x6502, 0): 0xC0, **(values or {})}, absent))


@pytest.mark.parametrize("index", [0x6065, 0x6066, 0x607D, 0x605A, 0x605D, 0x605E, 0x6007, 0x6085])
def test_missing_object_of_safety_is_named_with_its_loss_until_it_is_accepted(index: int) -> None:
    (problem,) = problems(Drive(node_id=1), index)
    assert problem.startswith(f"{index:04X}:")
    assert f'accept_missing = ["{index:04X}"]' in problem
    assert problems(Drive(node_id=1, accept_missing=(f"{index:04X}",)), index) == []


def test_watchdog_is_missing_only_where_no_other_one_is_there() -> None:
    assert problems(Drive(node_id=1), 0x1016) == []  # guarding
    assert problems(Drive(node_id=1), 0x1016, 0x100D) == []  # time-out of the RPDO
    (problem,) = problems(Drive(node_id=1), 0x1016, 0x100D, (0x1400, 5))
    assert "does not stop when this program or the cable fails" in problem


def test_torque_offset_needs_its_object_and_the_rated_torque_of_the_drive() -> None:
    drive = Drive(node_id=1, torque_offset=True, rated_torque=21.0, gear=21.0)
    assert problems(drive) == problems(drive, values={(0x6076, 0): 1005}) == []
    (missing,) = problems(drive, 0x60B2)
    assert missing.startswith("60B2:00 torque offset: no such object")
    (differs,) = problems(drive, values={(0x6076, 0): 1500})
    assert "6076h of the drive gives 31.5 N m" in differs
    assert "rated_torque of the rig file is 21 N m" in differs
    unused = drive.model_copy(update={"torque_offset": False})
    assert problems(unused, 0x60B2, values={(0x6076, 0): 1500}) == []


@pytest.mark.parametrize("index", [0x6041, 0x6060, 0x6064, 0x607A])
def test_object_of_motion_cannot_be_accepted_as_missing(index: int) -> None:
    assert any(
        "no such object" in text for text in problems(Drive(node_id=1, accept_missing=(f"{index:04X}",)), index)
    )


@pytest.mark.parametrize("index", [0x1006, 0x1017, 0x603F, 0x6061])
def test_objects_of_convenience_may_be_missing(index: int) -> None:
    assert problems(Drive(node_id=1), index) == []


@pytest.mark.parametrize(
    ("modes", "assumed", "text"),
    [
        (0x80, False, None),
        (0x40, True, 'mode = "interpolated" is there'),
        (0x25, True, "neither mode 7 nor 8"),
        (0, False, "none named"),
        (0, True, None),
    ],
)
def test_mode_is_listed_or_assumed(modes: int, assumed: bool, text: str | None) -> None:
    found = problems(Drive(node_id=1, assume_mode=assumed), values={(0x6502, 0): modes})
    assert found == [] if text is None else text in found[0]


def test_unit_is_asked_only_where_a_ramp_is_written() -> None:
    drive = Drive(node_id=1, accept_missing=("6085",))
    assert any("unit of acceleration" in text for text in problems(drive, 0x60AA))
    assert problems(drive, 0x60AA, 0x6085, 0x6084) == []
