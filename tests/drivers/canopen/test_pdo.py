import pytest

from drivers.canopen import pdo
from recordings.errors import BadInput
from recordings.rig import Drive, Rig, Torque, Voltage
from tests.drivers.canopen.given import dictionary, values_of


@pytest.mark.parametrize(
    ("drive", "names", "mapped"),
    [
        (Drive(node_id=1), [["status", "position", "voltage"]], 0x2200_01_10),
        (Drive(node_id=1, torque_actual=True), [["status", "position", "voltage"], ["torque"]], 0x6077_00_10),
        (
            Drive(node_id=1, torque_actual=True, voltage=Voltage(transfer="sdo")),
            [["status", "position", "torque"]],
            0x6077_00_10,
        ),
        (Drive(node_id=1, torque_source="torque_actual"), [["status", "position", "torque"]], 0x6077_00_10),
        (
            Drive(node_id=1, torque_source="current_actual", rated_current=2.0),
            [["status", "position", "torque"]],
            0x6078_00_10,
        ),
    ],
)
def test_tpdos_by_voltage_transfer_and_torque(drive: Drive, names: list[list[str]], mapped: int) -> None:
    pdos = pdo.tpdos(dictionary(drive))
    assert [[field.name for field in each.fields] for each in pdos] == names
    assert pdos[-1].fields[-1].mapped(1) == mapped
    assert [each.layout.size for each in pdos] == [8, *([2] if len(names) > 1 else [])]


def test_torque_offset_fills_the_rpdo() -> None:
    drive = Drive(node_id=1, torque_offset=True)
    writes = values_of(pdo.pdo_writes(dictionary(drive)))
    assert [writes[0x1600, sub] for sub in range(4)] == [3, 0x6040_00_10, 0x607A_00_20, 0x60B2_00_10]


@pytest.mark.parametrize(
    ("size", "signed", "mapped", "layouts"),
    [
        (1, None, 0x2200_01_08, "Hib"),
        (2, None, 0x2200_01_10, "Hih"),
        (2, False, 0x2200_01_10, "HiH"),
        (4, None, 0x2200_01_20, "Hi|i"),
        (4, False, 0x2200_01_20, "Hi|I"),
    ],
)
def test_size_of_the_voltage_is_the_drives(size: int, signed: bool | None, mapped: int, layouts: str) -> None:
    drive = Drive(node_id=1, voltage=Voltage(signed=signed))
    pdos = pdo.tpdos(dictionary(drive, {(0x2200, 1): bytes(size)}))
    assert pdos[-1].fields[-1].mapped(1) == mapped
    assert "|".join(each.layout.format[1:] for each in pdos) == layouts


def test_supply_is_unsigned_by_the_standard() -> None:
    assert not pdo.voltage_is_signed(Drive(node_id=1, voltage=Voltage(index=0x6079, sub=0)))
    assert pdo.voltage_is_signed(Drive(node_id=1, voltage=Voltage(index=0x6079, sub=0, signed=True)))


def test_cob_id_keeps_bit_30_and_is_compared_without_it_and_reserved_bits() -> None:
    drive = Drive(node_id=5)
    writes = pdo.pdo_writes(dictionary(drive, {(0x1800, 1): 0x4000_0185}))
    last = [write for write in writes if write.index == 0x1800][-1]
    assert last.value == 0x4000_0185
    differs = [bool((read_back ^ last.value) & last.mask) for read_back in (0x1FFF_F985, 0x8000_0185, 0x186)]
    assert differs == [False, True, True]


@pytest.mark.parametrize(
    ("values", "absent", "reason"),
    [
        ({}, ((0x1400, 1),), "RPDO"),
        ({}, ((0x1801, 1),), "TPDO"),
        ({(0x1404, 1): 0x8000_0000}, ((0x1400, 1),), "0 found among the 4 that have COB-IDs"),
        ({(0x1804, 1): 0x8000_0000}, ((0x1800, 1),), r"2 TPDO\(s\) or more needed for .*, 1 found among the 4"),
        ({(0x2200, 1): bytes(8)}, (), "has 8 bytes"),
    ],
)
def test_drive_with_too_few_pdos_or_no_integer_is_refused(values, absent, reason: str) -> None:
    drive = Drive(node_id=5, torque_actual=True)
    with pytest.raises(BadInput, match=reason):
        pdo.pdo_writes(dictionary(drive, values, absent))


def test_objects_that_fit_nowhere_are_tried_in_full_mappings() -> None:
    drive = Drive(node_id=5)
    objects = dictionary(drive, {(0x1A00, 1): bytes(4)}, absent=((0x1801, 1),))
    assert [len(each.fields) for each in pdo.tpdos(objects)] == [3]


@pytest.mark.parametrize(
    ("drive", "effort"),
    [
        (Drive(node_id=1, torque_source="torque_actual", rated_torque=20.0, sign=-1), -0.02),
        (Drive(node_id=1, torque_source="current_actual", rated_current=4.0), 4e-3 * 0.5),
    ],
)
def test_effort_per_count(drive: Drive, effort: float) -> None:
    torque = Torque(gain=(1.0,), per_ampere=(0.5,))
    rig = Rig(name="axis", mechanism="axes", axes=({},), drives=(drive,), torque=torque)  # type: ignore[arg-type]
    assert pdo.effort_per_count(rig, 0) == pytest.approx(effort)
