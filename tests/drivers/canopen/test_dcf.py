from pathlib import Path

import pytest

from drivers.canopen import dcf, setup
from drivers.canopen.sdo import SdoWrite
from recordings.errors import BadInput
from recordings.rig import Drive, simulated_rig

EDS = Path(setup.__file__).parents[1] / "simulated" / "drive.eds"


def drive_with(folder: Path, values: dict[str, str]) -> Drive:
    """A drive whose DCF gives `values` to sections of the simulated drive's dictionary."""
    text = EDS.read_text()
    for section, value in values.items():
        assert f"[{section}]\n" in text
        text = text.replace(f"[{section}]\n", f"[{section}]\nParameterValue={value}\n")
    (folder / "drive.dcf").write_text(text)
    return Drive(node_id=1, dcf=str(folder / "drive.dcf"))


def test_values_come_first(tmp_path: Path) -> None:
    writes = setup.sdo_writes(simulated_rig(), drive_with(tmp_path, {"6085": "777"}))
    assert writes[0] == SdoWrite(0x6085, 0, "<I", 777)
    assert writes[1].index == 0x6060


def test_mode_control_targets_and_what_cannot_be_written_are_left_out(tmp_path: Path) -> None:
    drive = drive_with(tmp_path, {"6040": "0x0F", "6060": "1", "607A": "5", "6502": "3", "605A": "6"})
    assert [(write.index, write.value) for write in dcf.configuration(drive)] == [(0x605A, 6)]


def test_write_only_objects_are_left_out(tmp_path: Path) -> None:
    drive = drive_with(tmp_path, {"6085": "7"})
    text = Path(str(drive.dcf)).read_text()
    section = text[text.index("[6085]") :].split("\n\n")[0]
    Path(str(drive.dcf)).write_text(text.replace(section, section.replace("AccessType=rw", "AccessType=wo")))
    assert dcf.configuration(drive) == []


def test_process_data_is_not_read_back(tmp_path: Path) -> None:
    text = EDS.read_text().replace("[6085]\n", "[6085]\nParameterValue=777\n")
    section = text[text.index("[6085]") :].split("\n\n")[0]
    (tmp_path / "a.dcf").write_text(text.replace(section, section.replace("PDOMapping=0", "PDOMapping=1")))
    (write,) = dcf.configuration(Drive(node_id=1, dcf=str(tmp_path / "a.dcf")))
    assert (write.index, write.check) == (0x6085, False)


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


def test_eds_without_values_is_refused_with_that_reason() -> None:
    with pytest.raises(BadInput, match="it is an EDS"):
        dcf.configuration(Drive(node_id=1, dcf=str(EDS)))


@pytest.mark.parametrize(("text", "reason"), [("[1000\n", "DCF file .* expected"), (None, "does not exist")])
def test_file_that_is_no_dcf_is_refused(text: str | None, reason: str, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / "bad.dcf").write_text(text)
    with pytest.raises(BadInput, match=reason):
        setup.sdo_writes(simulated_rig(), Drive(node_id=1, dcf=str(tmp_path / "bad.dcf")))
