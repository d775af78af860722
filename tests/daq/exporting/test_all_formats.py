"""Export formats: the usual reader of each format finds the values of the recording."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from can import CanutilsLogReader
from pyarrow import parquet

from daq import exporting
from daq.commands.export import command
from recordings.errors import BadInput
from recordings.reader import read, read_can
from recordings.rig import simulated_rig
from recordings.writer import RecordingWriter
from tests.made_up import run_of
from tests.running import printed

STAMP = 1_700_000_000_000_000_000


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    """Recording of five SYNCs with a gap in the third, and frames of every type."""
    path = tmp_path / "run.mcap"
    with RecordingWriter(path, simulated_rig(), run_of(period=0.004)) as writer:
        writer.can(STAMP, STAMP + 1_234_567, 0x123, b"\x2a\x36\xff", sent=True)
        writer.can(STAMP, STAMP + 2_000_000, 0x12345, b"", sent=False, extended=True)
        writer.can(STAMP, STAMP + 3_000_000, 0x7F, b"", sent=False, rtr=True)
        writer.can(STAMP, STAMP + 4_000_000, 0x84, bytes(8), sent=False, error=True)
        for k in range(5):
            stamp = STAMP + k * 2_000_000
            position = (0.1 * k, np.nan if k == 2 else 0.2, -1 / 3)
            writer.joint_states(stamp, stamp, position)
            writer.joint_commands(stamp, stamp, (0.1, 0.2, 0.3))
            writer.amplifiers(stamp, stamp, k, k // 2 - 1, k * 1e-4, (1.0, 2.0, 3.0), (7, 8, 9), (0, 0, k))
    return path


def exported(recording: Path, form: str) -> Path:
    out = recording.with_suffix(f".{form}")
    exporting.export(recording, form, out)
    return out


def test_csv_holds_the_recording(recording: Path) -> None:
    lines = exported(recording, "csv").read_text().splitlines()
    assert lines[0].split(",") == [
        "time",
        *(f"{name}_{i}" for name in ("position", "command", "voltage") for i in (1, 2, 3)),
        "cycle",
    ]
    assert lines[3] == "0.004,0.2,,-0.3333333333333333,0.1,0.2,0.3,1.0,2.0,3.0,0"
    assert len(lines) == 6


def test_parquet_holds_the_recording(recording: Path) -> None:
    table = parquet.read_table(exported(recording, "parquet"))
    assert table.column("position_2").to_pylist() == [0.2, 0.2, None, 0.2, 0.2]
    assert table.column("error_code_3").to_pylist() == [0, 1, 2, 3, 4]
    np.testing.assert_array_equal(table.column("time").to_numpy(), read(recording).time)
    assert json.loads(table.schema.metadata[b"run"])["trajectory"] == "fig5a"
    assert json.loads(table.schema.metadata[b"rig"])["mechanism"] == "delta"


def test_parquet_without_pyarrow_names_the_missing_package(
    recording: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(BadInput, match=r"pip install 'delta-workbench\[parquet\]'"):
        exported(recording, "parquet")
    assert not (tmp_path / "run.parquet").exists()


def test_mat_file_holds_the_recording(recording: Path) -> None:
    from scipy.io import loadmat

    contents, whole = loadmat(exported(recording, "mat")), read(recording)
    for name in ("position", "command", "voltage", "statusword", "error_code"):
        np.testing.assert_array_equal(contents[name], getattr(whole, name), err_msg=name)
    for name, array in (("time", whole.time), ("cycle", whole.repeat), ("lateness", whole.lateness)):
        np.testing.assert_array_equal(contents[name], array[:, None], err_msg=name)
    assert np.isnan(contents["velocity"]).all()
    assert [name.item() for name in contents["joint_names"].ravel()] == ["joint_1", "joint_2", "joint_3"]
    assert json.loads(contents["run"].item())["period"] == 0.004


def test_candump_log_holds_the_frames_as_python_can_reads_them(recording: Path) -> None:
    log = exported(recording, "candump").rename(recording.with_suffix(".log"))
    assert log.read_text().splitlines() == [
        "(1700000000.001234) can0 123#2A36FF",
        "(1700000000.002000) can0 00012345#",
        "(1700000000.003000) can0 07F#R",
        "(1700000000.004000) can0 20000084#0000000000000000",
    ]
    with CanutilsLogReader(log) as reader:
        messages, frames = list(reader), read_can(recording)
    # python-can drops the id of an error frame.
    assert [message.arbitration_id for message in messages[:3]] == frames.id[:3].tolist()
    assert [message.is_remote_frame for message in messages] == frames.rtr.tolist()
    assert [message.is_error_frame for message in messages] == frames.error.tolist()


@pytest.mark.parametrize("form", exporting.names())
def test_export_never_overwrites_and_leaves_no_partial_file(form: str, recording: Path) -> None:
    out = recording.with_suffix(".out")
    out.write_text("precious")
    with pytest.raises(BadInput, match="exists"):
        exporting.export(recording, form, out)
    assert out.read_text() == "precious"
    (recording.parent / "noise.mcap").write_text("noise")
    with pytest.raises(BadInput):
        exporting.export(recording.parent / "noise.mcap", form, recording.parent / "other")
    assert not (recording.parent / "other").exists()


def test_candump_rejects_a_recording_without_frames(tmp_path: Path) -> None:
    from recordings.importing import Description, import_data

    (tmp_path / "data.csv").write_text("time,position_1,effort_1\n0,1,1\n1,2,2\n")
    import_data(tmp_path / "data.csv", tmp_path / "r.mcap", Description(mechanism="axes"))
    with pytest.raises(BadInput, match="frames of a CAN bus expected, none found"):
        exported(tmp_path / "r.mcap", "candump")
    for form in ("csv", "mat"):
        exported(tmp_path / "r.mcap", form)


def test_export_command_writes_the_file(recording: Path) -> None:
    assert printed(command, recording, "--to", "candump") == f"{recording.with_suffix('.log')}: 4 frames\n"
    document = json.loads(printed(command, recording, "--to", "mat", "--json"))
    assert document["out"] == str(recording.with_suffix(".mat"))
    with pytest.raises(BadInput, match="xls"):
        printed(command, recording, "--to", "xls")


def test_help_imports_no_heavy_package() -> None:
    code = (
        "import sys; from daq.commands import export, trajectories; "
        "assert not {'numpy', 'scipy', 'pyarrow', 'matplotlib', 'pydantic'} & set(sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
