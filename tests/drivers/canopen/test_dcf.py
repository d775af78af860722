from pathlib import Path

import pytest

from drivers.canopen import dcf
from drivers.canopen.sdo import SdoWrite
from drivers.simulated.mark import EDS
from recordings.errors import BadInput
from recordings.rig import Axis, Drive, Limits, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus
from tests.faults.habits import Change, all_of, entry


def drive_with(folder: Path, values: dict[str, str], *changes: Change) -> Drive:
    """A drive whose DCF gives `values` to sections of the simulated drive's dictionary, with further changes."""
    text = all_of(*changes)(EDS.read_text())
    for section, value in values.items():
        assert f"[{section}]\n" in text
        text = text.replace(f"[{section}]\n", f"[{section}]\nParameterValue={value}\n")
    (folder / "drive.dcf").write_text(text)
    return Drive(node_id=1, dcf=str(folder / "drive.dcf"))


def test_the_rig_file_has_the_last_word_over_values_of_the_dcf(tmp_path: Path) -> None:
    drive, ramps = drive_with(tmp_path, {"6085": "777"}), list[int]()
    bus = LossyBus(Rig(name="axis", mechanism="axes", axes=(Axis(),), drives=(drive,), torque=Torque(gain=(1.0,))))

    def note(arbitration_id: int, data: bytes) -> None:
        if arbitration_id == 0x601 and data[:4] == bytes.fromhex("23 85 60 00"):
            ramps.append(int.from_bytes(data[4:], "little"))

    bus.witness = note
    driver = bus.driver()
    driver.discover()
    driver.configure()
    driver.close()
    assert ramps == [777, round(Limits().acceleration * drive.counts_per_radian)]


def test_what_acts_at_once_or_cannot_be_written_or_read_is_left_out_and_process_data_not_compared(
    tmp_path: Path,
) -> None:
    values = {"6040": "0x0F", "6060": "1", "607A": "5", "6502": "3", "605A": "6", "6085": "7", "6065": "9"}
    changes = entry("6085", AccessType="wo"), entry("6065", PDOMapping="1")
    writes = dcf.configuration(drive_with(tmp_path, values, *changes))
    assert writes == [SdoWrite(0x605A, 0, "<H", 6), SdoWrite(0x6065, 0, "<I", 9, check=False)]


def test_pdos_come_last_in_the_order_of_cia_301_and_stay_off(tmp_path: Path) -> None:
    values = {"1A00sub1": "0x60410010", "1800sub1": "0x181", "1800sub2": "1", "1A00sub0": "1", "6085": "7"}
    writes = dcf.configuration(drive_with(tmp_path, values))
    assert [(write.index, write.sub, write.value) for write in writes] == [
        (0x6085, 0, 7),
        (0x1800, 1, 0x8000_0181),
        (0x1800, 2, 1),
        (0x1A00, 0, 0),
        (0x1A00, 1, 0x6041_0010),
        (0x1A00, 0, 1),
    ]


@pytest.mark.parametrize(
    ("text", "reason"),
    [(EDS.read_text(), "it is an EDS"), ("[1000\n", "line 1, .* expected"), (None, "does not exist")],
)
def test_file_that_is_no_dcf_is_refused(text: str | None, reason: str, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "bad.dcf").write_text(text)
    with pytest.raises(BadInput, match=reason):
        dcf.configuration(Drive(node_id=1, dcf=str(tmp_path / "bad.dcf")))
