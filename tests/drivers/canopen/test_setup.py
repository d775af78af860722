from pathlib import Path

import pytest

from drivers.canopen import setup
from drivers.simulated.mark import EDS
from recordings.errors import BadInput
from recordings.rig import Drive, Voltage, simulated_rig


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


def test_tpdos_by_voltage_transfer_and_torque_actual() -> None:
    both = Drive(node_id=1, torque_actual=True)
    polled = Drive(node_id=1, torque_actual=True, voltage=Voltage(transfer="sdo"))
    names = [
        [[f.name for f in fields] for fields in setup.tpdos(drive)] for drive in (Drive(node_id=1), both, polled)
    ]
    assert names == [
        [["status", "position", "voltage"]],
        [["status", "position", "voltage"], ["torque"]],
        [["status", "position", "torque"]],
    ]
    assert setup.pdo_sizes(both) == [6, 8, 2]


def test_parameter_values_of_a_dcf_come_first(tmp_path: Path) -> None:
    text = EDS.read_text().replace("[6085]\n", "[6085]\nParameterValue=777\n")
    (tmp_path / "drive.dcf").write_text(text)
    entries = setup.sdo_writes(simulated_rig(), Drive(node_id=1, dcf=str(tmp_path / "drive.dcf")))
    assert entries[0] == setup.SdoWrite(0x6085, 0, "<I", 777)
    assert entries[1].index == 0x6060


def test_malformed_dcf_is_refused(tmp_path: Path) -> None:
    (tmp_path / "bad.dcf").write_text("[1000\n")
    with pytest.raises(BadInput, match="cannot be read"):
        setup.sdo_writes(simulated_rig(), Drive(node_id=1, dcf=str(tmp_path / "bad.dcf")))
