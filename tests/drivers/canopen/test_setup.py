import math

import pytest

from drivers.canopen import setup
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from recordings.errors import BadInput
from recordings.rig import AssumedUnits, Drive, simulated_rig


@pytest.mark.parametrize(
    ("rate", "period"),
    [(500, (2, -3)), (1000, (1, -3)), (200, (5, -3)), (400, (25, -4)), (250, (4, -3)), (4000, (25, -5))],
)
def test_interpolation_period(rate: float, period: tuple[int, int]) -> None:
    assert setup.interpolation_period(rate) == period


def test_interpolation_period_that_does_not_fit_its_object_is_refused() -> None:
    with pytest.raises(BadInput, match="choose a rate such as"):
        setup.interpolation_period(333.0)


def test_pdo_is_disabled_while_its_mapping_is_written() -> None:
    entries = setup.sdo_writes(simulated_rig(), Drive(node_id=5))
    rpdo = [(e.index, e.sub, e.value) for e in entries if e.index in (0x1400, 0x1600)]
    assert rpdo == [
        (0x1400, 1, 0x8000_0205),
        (0x1400, 2, 1),
        (0x1600, 0, 0),
        (0x1600, 1, 0x6040_0010),
        (0x1600, 2, 0x607A_0020),
        (0x1600, 0, 2),
        (0x1400, 1, 0x205),
    ]


def test_position_limits_are_ordered_for_a_drive_that_counts_backwards() -> None:
    entries = {(e.index, e.sub): e.value for e in setup.sdo_writes(simulated_rig(), Drive(node_id=1, sign=-1))}
    assert entries[0x607D, 1] < entries[0x607D, 2]


def test_rate_and_limits_become_objects_in_the_drives_units() -> None:
    rpm = {"units": {"acceleration": "rpm/s"}}
    drive = Drive(node_id=1, counts_per_turn=8192, gear=21.0).model_validate({"node_id": 1, **rpm})
    dictionary = standard_dictionary(drive)
    silent = DriveDictionary(drive, {a: d for a, d in dictionary.data.items() if a != (0x60AA, 0)})
    writes = {(e.index, e.sub): e for e in setup.own_writes(simulated_rig(), drive, silent)}
    assert writes[0x6085, 0].value == round(150 * 21 * 60 / math.tau)
    assert writes[0x605A, 0].value == 2


def test_slow_down_ramp_is_written_where_a_stop_uses_it() -> None:
    writes = {
        (e.index, e.sub): e.value for e in setup.sdo_writes(simulated_rig(), Drive(node_id=1, quick_stop_option=5))
    }
    assert writes[0x6084, 0] == writes[0x6085, 0]
    assert writes[0x605A, 0] == 5
    assert (0x6084, 0) not in {(e.index, e.sub) for e in setup.sdo_writes(simulated_rig(), Drive(node_id=1))}


def test_objects_that_the_drive_lacks_are_not_written_and_sizes_are_its_own() -> None:
    drive = Drive(node_id=1)
    data = dict(standard_dictionary(drive).data)
    del data[0x6066, 0]
    data[0x605A, 0] = bytes(1)
    writes = {(e.index, e.sub): e for e in setup.own_writes(simulated_rig(), drive, DriveDictionary(drive, data))}
    assert (0x6066, 0) not in writes
    assert writes[0x605A, 0].layout == "<b"


@pytest.mark.parametrize(
    ("objects", "written"),
    [
        ({(0x1016, 1), (0x100C, 0), (0x100D, 0), (0x1400, 5)}, {(0x1016, 1): 127 << 16 | 250, (0x1017, 0): 100}),
        ({(0x100C, 0), (0x100D, 0), (0x1400, 5)}, {(0x100C, 0): 100, (0x100D, 0): 3, (0x1017, 0): 0}),
        ({(0x100C, 0), (0x1400, 5)}, {(0x1400, 5): 100, (0x1017, 0): 100}),
        (set(), {(0x1017, 0): 100}),
    ],
)
def test_watchdog_is_the_best_that_the_drive_has(
    objects: set[tuple[int, int]], written: dict[tuple[int, int], int]
) -> None:
    drive = Drive(node_id=1)
    ways = {(0x1016, 1), (0x100C, 0), (0x100D, 0), (0x1400, 5)}
    data = {a: d for a, d in standard_dictionary(drive).data.items() if a not in ways}
    data |= {address: bytes(4 if address == (0x1016, 1) else 2) for address in objects}
    dictionary = DriveDictionary(drive, data)
    writes = {(e.index, e.sub): e.value for e in setup.own_writes(simulated_rig(), drive, dictionary)}
    assert {a: v for a, v in writes.items() if a in ways | {(0x1017, 0)}} == written
    assert {(e.index, e.sub) for e in setup.watchdog_off(dictionary)} == set(written) - {(0x1017, 0)}


@pytest.mark.parametrize(("unit", "value"), [("0.001 rpm/s", 30_080_300), ("1000 rpm/s", 30), ("100000 rpm/s", None)])
def test_unit_that_is_too_coarse_for_the_quick_stop_is_refused(unit: str, value: int | None) -> None:
    drive = Drive(node_id=1, units=AssumedUnits(acceleration=unit))
    data = {a: d for a, d in standard_dictionary(drive).data.items() if a != (0x60AA, 0)}
    if value is None:
        with pytest.raises(BadInput, match="cannot be written in the drive's unit"):
            setup.own_writes(simulated_rig(), drive, DriveDictionary(drive, data))
    else:
        writes = setup.own_writes(simulated_rig(), drive, DriveDictionary(drive, data))
        assert next(e.value for e in writes if e.index == 0x6085) == pytest.approx(value, rel=1e-4)
