import pytest

from drivers.canopen import requirements, setup
from drivers.eds import Address
from recordings.errors import BadInput
from recordings.rig import AssumedUnits, Drive, simulated_rig
from tests.drivers.canopen.given import dictionary, values_of

RIG = simulated_rig()


@pytest.mark.parametrize(
    ("rate", "period"),
    [(500, (2, -3)), (1000, (1, -3)), (200, (5, -3)), (400, (25, -4)), (250, (4, -3)), (4000, (25, -5))],
)
def test_interpolation_period(rate: float, period: tuple[int, int]) -> None:
    assert requirements.interpolation_period(rate) == period
    with pytest.raises(BadInput, match="choose a rate such as"):
        requirements.interpolation_period(333.0)


def test_limits_are_ordered_for_a_drive_that_counts_backwards_and_the_slow_ramp_written_where_a_stop_uses_it() -> (
    None
):
    usual = values_of(setup.own_writes(RIG, dictionary(Drive(node_id=1, sign=-1))))
    assert usual[0x607D, 1] < usual[0x607D, 2]
    assert (0x6084, 0) not in usual
    slow = values_of(setup.own_writes(RIG, dictionary(Drive(node_id=1, quick_stop_option=5))))
    assert slow[0x6084, 0] == slow[0x6085, 0]
    assert (usual[0x605A, 0], slow[0x605A, 0]) == (2, 5)


def test_objects_that_the_drive_lacks_are_not_written_and_sizes_are_its_own() -> None:
    drive = Drive(node_id=1)
    of_drive = dictionary(drive, {(0x605A, 0): bytes(1)}, absent=(0x6066,))
    writes = {write.index: write for write in setup.own_writes(RIG, of_drive)}
    assert 0x6066 not in writes
    assert writes[0x605A].layout == "<b"


WAYS: tuple[Address, ...] = ((0x1016, 1), (0x100C, 0), (0x100D, 0), (0x1400, 5))


@pytest.mark.parametrize(
    ("objects", "written"),
    [
        (WAYS, {(0x1016, 1): 127 << 16 | 250, (0x1017, 0): 100}),
        (WAYS[1:], {(0x100C, 0): 100, (0x100D, 0): 3, (0x1017, 0): 0}),
        ((WAYS[1], WAYS[3]), {(0x1400, 5): 100, (0x1017, 0): 100}),
        ((), {(0x1017, 0): 100}),
    ],
)
def test_watchdog_is_the_best_that_the_drive_has(objects: tuple[Address, ...], written: dict[Address, int]) -> None:
    drive = Drive(node_id=1)
    values = {address: bytes(4 if address == (0x1016, 1) else 2) for address in objects}
    of_drive = dictionary(drive, values, absent=tuple(set(WAYS) - set(objects)))
    writes = values_of(setup.own_writes(RIG, of_drive))
    assert {a: v for a, v in writes.items() if a in {*WAYS, (0x1017, 0)}} == written
    assert values_of(setup.watchdog_off(of_drive)) == dict.fromkeys(written.keys() - {(0x1017, 0)}, 0)


@pytest.mark.parametrize(("absent", "way"), [((0x1017,), "guarding"), ((0x1017, 0x100C), "heartbeat")])
def test_a_drive_without_a_heartbeat_is_guarded_where_it_can_be(absent: tuple[int, ...], way: str) -> None:
    of_drive = dictionary(Drive(node_id=1), absent=absent)
    assert of_drive.watchdog == way
    assert ((0x1016, 1) in values_of(setup.own_writes(RIG, of_drive))) == (way == "heartbeat")


@pytest.mark.parametrize(("unit", "value"), [("0.001 rpm/s", 30_080_300), ("1000 rpm/s", 30), ("100000 rpm/s", None)])
def test_unit_that_is_too_coarse_for_the_quick_stop_is_refused(unit: str, value: int | None) -> None:
    drive = Drive(node_id=1, units=AssumedUnits(acceleration=unit))
    silent = dictionary(drive, absent=(0x60AA,))
    if value is None:
        with pytest.raises(BadInput, match="cannot be written in the drive's unit"):
            setup.own_writes(RIG, silent)
    else:
        assert values_of(setup.own_writes(RIG, silent))[0x6085, 0] == pytest.approx(value, rel=1e-4)


def test_offset_that_a_killed_run_left_is_cleared_in_any_run() -> None:
    drive = Drive(node_id=1)
    left = dictionary(drive, {(0x60B2, 0): (-250).to_bytes(2, "little", signed=True)})
    assert values_of(setup.own_writes(RIG, left))[0x60B2, 0] == 0
    assert (0x60B2, 0) not in values_of(setup.own_writes(RIG, dictionary(drive)))
