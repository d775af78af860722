import pytest

from drivers.canopen import pdo
from drivers.canopen.dictionary import DriveDictionary, standard_dictionary
from recordings.errors import BadInput
from recordings.rig import Drive, Rig, Torque, Voltage


def dictionary(drive: Drive, **data: int) -> DriveDictionary:
    """Standard dictionary with COB-IDs, e.g. x1802=0x380; -1 removes."""
    changed = dict(standard_dictionary(drive).data)
    for name, cob_id in data.items():
        address = int(name[1:], 16), 1
        if cob_id < 0:
            del changed[address]
        else:
            changed[address] = cob_id.to_bytes(4, "little")
    return DriveDictionary(drive, changed)


def with_voltage(drive: Drive, size: int) -> DriveDictionary:
    data = {**standard_dictionary(drive).data, (drive.voltage.index, drive.voltage.sub): bytes(size)}
    return DriveDictionary(drive, data)


def test_tpdos_by_voltage_transfer_and_torque() -> None:
    drives = (
        Drive(node_id=1),
        Drive(node_id=1, torque_actual=True),
        Drive(node_id=1, torque_actual=True, voltage=Voltage(transfer="sdo")),
        Drive(node_id=1, torque_source="torque_actual"),
        Drive(node_id=1, torque_source="current_actual", rated_current=2.0),
    )
    assert [[[field.name for field in fields] for fields in pdo.tpdos(drive).values()] for drive in drives] == [
        [["status", "position", "voltage"]],
        [["status", "position", "voltage"], ["torque"]],
        [["status", "position", "torque"]],
        [["status", "position", "torque"]],
        [["status", "position", "torque"]],
    ]
    assert pdo.pdo_sizes(drives[1]) == [6, 8, 2]
    assert [hex(fields[-1].mapped) for fields in (list(pdo.tpdos(d).values())[-1] for d in drives[3:])] == [
        "0x60770010",
        "0x60780010",
    ]


def test_torque_offset_fills_the_rpdo() -> None:
    drive = Drive(node_id=1, torque_offset=True)
    assert [hex(mapped) for mapped in pdo.rpdos(drive)[0]] == ["0x60400010", "0x607a0020", "0x60b20010"]
    assert pdo.pdo_sizes(drive) == [8, 8]
    writes = {(write.index, write.sub): write.value for write in pdo.pdo_writes(drive, standard_dictionary(drive))}
    assert writes[0x1600, 3] == 0x60B2_00_10
    assert writes[0x1600, 0] == 3


@pytest.mark.parametrize(
    ("size", "signed", "mapped", "layouts"),
    [
        (1, None, 0x2200_01_08, ["H", "i", "b"]),
        (2, None, 0x2200_01_10, ["H", "i", "h"]),
        (2, False, 0x2200_01_10, ["H", "i", "H"]),
        (4, None, 0x2200_01_20, ["H", "i", "|", "i"]),
        (4, False, 0x2200_01_20, ["H", "i", "|", "I"]),
    ],
)
def test_size_of_the_voltage_is_the_drives(size: int, signed: bool | None, mapped: int, layouts: list[str]) -> None:
    drive = Drive(node_id=1, voltage=Voltage(signed=signed))
    pdos = list(pdo.tpdos(drive, with_voltage(drive, size)).values())
    assert pdos[-1][-1].mapped == mapped
    assert "|".join("".join(field.layout for field in fields) for fields in pdos) == "".join(layouts)


def test_supply_is_unsigned_by_the_standard() -> None:
    assert not pdo.voltage_is_signed(Drive(node_id=1, voltage=Voltage(index=0x6079, sub=0)))
    assert pdo.voltage_is_signed(Drive(node_id=1, voltage=Voltage(index=0x6079, sub=0, signed=True)))


def test_object_that_is_no_integer_is_refused() -> None:
    drive = Drive(node_id=1)
    with pytest.raises(BadInput, match="has 8 bytes"):
        pdo.tpdos(drive, with_voltage(drive, 8))


def test_other_pdos_are_switched_off_first() -> None:
    drive = Drive(node_id=5)
    objects = dictionary(drive, x1801=0x285, x1802=0x4000_0385, x1803=0x8000_0485, x1401=0x305)
    writes = pdo.pdo_writes(drive, objects)
    foreign = [(write.index, write.sub, write.value) for write in writes if pdo.is_foreign(write)]
    assert foreign == [(0x1401, 1, 0x8000_0305), (0x1801, 1, 0x8000_0285), (0x1802, 1, 0xC000_0385)]
    assert all(pdo.is_foreign(write) for write in writes[:3])


def test_cob_id_keeps_bit_30_and_is_compared_without_it_and_reserved_bits() -> None:
    drive = Drive(node_id=5)
    last = [write for write in pdo.pdo_writes(drive, dictionary(drive, x1800=0x4000_0185)) if write.index == 0x1800][
        -1
    ]
    assert last.value == 0x4000_0185
    read_back = 0x1FFF_F800 | 0x185
    assert not (read_back ^ last.value) & last.mask
    assert (0x8000_0185 ^ last.value) & last.mask
    assert (0x0000_0186 ^ last.value) & last.mask


def test_pdo_with_another_cob_id_is_disabled_before_it_gets_ours() -> None:
    drive = Drive(node_id=5)
    writes = [write for write in pdo.pdo_writes(drive, dictionary(drive, x1800=0x3A7)) if write.index == 0x1800]
    assert [write.value for write in writes] == [0x8000_03A7, 1, 0x185]


@pytest.mark.parametrize(("missing", "kind"), [("x1400", "RPDO"), ("x1801", "TPDO")])
def test_drive_with_too_few_pdos_is_refused(missing: str, kind: str) -> None:
    drive = Drive(node_id=5, torque_actual=True)
    with pytest.raises(BadInput, match=kind):
        pdo.pdo_writes(drive, dictionary(drive, **{missing: -1}))


def test_objects_that_fit_nowhere_are_tried_in_full_mappings() -> None:
    drive = Drive(node_id=5)
    data = {address: value for address, value in standard_dictionary(drive).data.items() if address != (0x1801, 1)}
    objects = DriveDictionary(drive, {**data, (0x1A00, 1): bytes(4)})
    assert [len(fields) for fields in pdo.tpdos(drive, objects).values()] == [3]


def test_effort_per_count() -> None:
    torque = Drive(node_id=1, torque_source="torque_actual", rated_torque=20.0, sign=-1)
    assert pdo.effort_per_count(_rig(torque), 0) == pytest.approx(-0.02)
    current = Drive(node_id=1, torque_source="current_actual", rated_current=4.0)
    assert pdo.effort_per_count(_rig(current), 0) == pytest.approx(4e-3 * 0.5)


def _rig(drive: Drive) -> Rig:
    return Rig(
        name="axis",
        mechanism="axes",
        axes=({},),
        drives=(drive,),
        torque=Torque(gain=(1.0,), per_ampere=(0.5,)),  # type: ignore[arg-type]
    )
