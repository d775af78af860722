"""Wrong inputs of `daq import`, and of the commands after it: exit 2, a sentence with the place and the remedy."""

import shlex
from pathlib import Path
from typing import NoReturn

import pytest

from tests.conftest import Runner
from tests.recordings.importing.wrong_files import FILES

AXES = ["--mechanism", "axes"]
OUT = ["--out", "new.mcap"]

WRONG = {
    "no file": ("none.csv", "none.csv does not exist; check the path"),
    "output is no recording": ("table.csv --out new.csv --mechanism axes", "(.mcap) expected"),
    "output exists": ("table.csv --out there.mcap --mechanism axes", "exists; give another one"),
    "output in a folder that takes none": (
        "table.csv --out /proc/new.mcap --mechanism axes",
        "folder /proc takes no new files; choose another one",
    ),
    "output in no folder": ("table.csv --out none/new.mcap --mechanism axes", "folder none does not exist"),
    "empty": ("empty.csv", "empty.csv, line 1: a header row"),
    "a header only": (
        "header.csv --mechanism axes",
        "rows of numbers expected, 0 found below the names time, position_1, voltage_1; export",
    ),
    "guess of a header only": (
        "header.csv --guess",
        "rows of numbers expected, 0 found below the names time, position_1, voltage_1; export",
    ),
    "a short row": ("short-row.csv --mechanism axes", "line 7: 3 cells as in the header expected, 2 found; complete"),
    "text in a cell": ("text-cell.csv --mechanism axes", "line 7, column 'position_1': a number expected, 'oops"),
    "time stands": ("two-times.csv --mechanism axes", "line 8, column 'time': a time after 0.05 s expected"),
    "time is missing": ("no-time.csv --mechanism axes", "line 8, column 'time': a time expected, none found"),
    "a column twice": ("twice.csv --mechanism axes", "'position_1' twice found; rename one"),
    "a joint is missing": ("gap.csv --mechanism axes", "position_1 is missing; map it"),
    "half a cycle": ("half-cycle.csv --mechanism axes", "column 'cycle': a whole number expected, 0.5 found"),
    "nothing that drives": ("no-drive.csv --mechanism axes", "none found; say which they are"),
    "columns of another program": ("scope.csv", "a column 'time' expected, t, q1, i1, state found; say which"),
    "time alone is mapped": ("scope.csv --map time=t:ms", "position_1, position_2, ... expected, t, q1"),
    "current without constant": (
        "scope.csv --map time=t:ms --map position_1=q1:deg --map current_1=i1:A --mechanism axes",
        "give --kt, or torque.per_ampere",
    ),
    "map without equals": ("scope.csv --map position_1:q1", "NAME=COLUMN:UNIT"),
    "map to no quantity": ("scope.csv --map postion_1=q1", "did you mean position_1?"),
    "map of no column": (
        "scope.csv --map position_1=q2:deg",
        "a column 'q2' expected, t, q1, i1, state found; correct the name",
    ),
    "map in no unit": ("scope.csv --map position_1=q1:furlong", "'furlong' found; correct it"),
    "map twice": ("scope.csv --map time=t:s --map time=i1", "one column for time expected, two found"),
    "map of text": (
        "scope.csv --map time=t:ms --map position_1=q1:deg --map current_1=i1:A --kt 1 --map velocity_1=state",
        "line 2, column 'state': a number",
    ),
    "angle in ampere": (
        "scope.csv --map time=t:ms --map position_1=q1:A --map current_1=i1:A --kt 1",
        "'A' found; correct the unit",
    ),
    "angle in counts": (
        "scope.csv --map time=t:ms --map position_1=q1:counts --map current_1=i1:A --kt 1",
        "write counts/8192",
    ),
    "torque in percent": ("scope.csv --map time=t:ms --map position_1=q1:deg --map effort_1=i1:%", "write %*20"),
    "metres on a hinge": (
        "scope.csv --map time=t:ms --map position_1=q1:mm --map current_1=i1:A --kt 1",
        "of a revolute joint, 'mm' found",
    ),
    "time in degrees": (
        "scope.csv --map time=t:deg --map position_1=q1:deg --map current_1=i1:A --kt 1",
        "s, ms, us, ns expected for the time",
    ),
    "mapping file is missing": ("scope.csv --map none.toml", "mapping none.toml does not exist"),
    "mapping file is no TOML": ("scope.csv --map broken.toml", "broken.toml is not valid TOML"),
    "mapping file holds a number": ("scope.csv --map list.toml", "put it in quotes"),
    "mapping and guess": ("scope.csv --guess --map time=t", "leave one of them out"),
    "joints without axes": ("table.csv --joints prismatic", "add it, or leave --joints out"),
    "the weight of a robot": ("table.csv --mechanism delta --gravity", "three revolute joints expected"),
    "torque per ampere is a word": ("table.csv --mechanism axes --kt NUMBER", "--kt: numbers such as"),
    "two kinds for one": ("table.csv --mechanism axes --joints revolute,prismatic", "one each"),
    "infinity": ("infinite.csv --mechanism axes", "line 7, column 'position_1': a finite number expected, infinity"),
    "times beyond a stamp": ("late.csv --mechanism axes", 'say the unit, as in --map "time=time:ns"'),
    "one axis is no delta": ("table.csv", "three joints of a delta robot expected, 1 found; say what it is"),
    "rig of two axes": ("table.csv --rig two.toml", "2 joints expected by the rig file, 1"),
    "rig and options": ("table.csv --rig two.toml --kt 1", "both found; leave one out"),
    "two gains for one": ("table.csv --mechanism axes --gain 1,2", "--gain: one number, or 1"),
    "torque per ampere of torques": (
        "constant.csv --mechanism axes --kt 0.5",
        "constant.csv holds efforts, which need no torque per ampere; leave --kt out",
    ),
    "gain of torques": (
        "constant.csv --mechanism axes --gain 0.5",
        "constant.csv holds no voltages, which alone need a torque map or gain; leave these out",
    ),
    "a robot without a name": (
        "table.csv --mechanism axes --robot ' '",
        "--robot: a name expected, ' ' found; give one",
    ),
    "negative gain": ("table.csv --mechanism axes --gain -1", "numbers above 0 expected, '-1' found"),
    "unknown joint": ("table.csv --mechanism axes --joints ball", "'ball' found; choose"),
    "start is no date": ("table.csv --mechanism axes --start yesterday", "'yesterday' found"),
    "start without a time": ("table.csv --mechanism axes --start 2026-01-05", "2026-01-05T08:00:00Z expected"),
    "topic of a table": ("table.csv --topic /joint_states", "chooses from a ROS bag, csv found"),
    "a joint that is not in the table": ("six.csv --names 1,2,7", "--names: joints (1, 2, 3, 4, 5, 6) expected, '7'"),
    "six joints are no delta": ("six.csv", "6 found; say what it is with --rig, or with --mechanism axes"),
    "six joints are accepted unasked": ("six.csv --guess --yes", "6 joints, where a delta robot has three: choose"),
    "four joints, of which three are numbered": ("arm.csv --guess --yes", "4 joints, where a delta robot has three"),
    "a guess that lacks a number is accepted": ("scope.csv --guess --yes", "complete the command above"),
    "yes to nothing": ("table.csv --yes", "--yes accepts what --guess proposes; add --guess"),
    "a name twice": ("bag --names a,a", "each once, expected"),
    "bytes": (
        "binary.dat",
        "measurements expected (csv, feather, hdf5, mat, mdf4, npz, parquet, ros, tdms, twincat)",
    ),
    "thinned to nothing": ("table.csv --mechanism axes --thin 30", "--thin: at most 20 expected, 30 found; keep at"),
    "a document of another kind": ("deep.json", f"rows of numbers expected, 0 found below the names {60 * '['}"),
    "a picture": ("photo.jpg", "a JPEG picture found; give the file of the measurements"),
    "a document": ("report.pdf", "a PDF document found; give the file of the measurements"),
    "a workbook": ("book.xlsx", "an Excel workbook found; save its sheet as CSV"),
    "half a Parquet file": ("half.parquet", "half.parquet cannot be read as Parquet"),
    "uneven arrays": (
        "uneven.npz --mechanism axes",
        "time, effort (left out: position of shape (8,) and not 9 values long) found; say which",
    ),
    "complex numbers": (
        "complex.npz --mechanism axes",
        "time, effort, position (left out: position holds complex128) found; say which",
    ),
    "arrays that are no columns": (
        "cube.npz",
        "none (left out: q of shape (3, 3, 3); Ts of shape ()) found; say which",
    ),
    "half a database": ("half.db3", "half.db3 cannot be read as a ROS bag"),
    "another archive": ("bag.zip", "a ZIP archive found; unpack it"),
    "a folder that is no bag": ("folder", "a folder that is no bag found"),
    "a letter that is called a recording": (
        "letter.mcap",
        "letter.mcap: rows of numbers expected, 0 found below the names hello, world,, this, is, no, recording",
    ),
    "angle of no joint": (
        "huge-angle.csv --mechanism axes",
        "line 10, column 'position_1': position within ±1e+06 (SI units) expected, 1e+160 found; correct",
    ),
    "torque of no joint by its unit": (
        "table.csv --mechanism axes --map effort_1=voltage_1:A*1e300",
        "line 3, column 'voltage_1': effort within ±1e+09 (SI units) expected, 1e+300 found; correct",
    ),
    "torque per ampere of no motor": (
        "scope.csv --map time=t:ms --map position_1=q1:deg --map current_1=i1:A --mechanism axes --kt 1e300",
        "effort within ±1e+09 N m or N expected, 2.5e+299 found for joint 1; correct its torque per ampere",
    ),
    "a device": ("/dev/zero", "a device found; check the path"),
}
"""Arguments of `daq import`, with `--out new.mcap` where they name no output, and what its error holds."""

AFTER: dict[str, tuple[list[str], list[str], str]] = {
    "fit of the table itself": ([], ["fit", "table.csv"], "daq import table.csv"),
    "diagnosis of the table itself": ([], ["diagnose", "scope.csv"], "daq import scope.csv --guess"),
    "fit of a picture": (
        [],
        ["fit", "photo.jpg"],
        "photo.jpg is not an MCAP file, but a JPEG picture\nphoto.jpg: measurements expected",
    ),
    "comparison of a folder": ([], ["fit", "folder"], "name a file in it"),
    "report of the table itself": ([], ["report", "table.csv", "table.csv", "-o", "r.html"], "table.csv"),
    "fit of time in ms": (
        ["slow.csv"],
        ["fit", "new.mcap"],
        "time-unit: A sample every 2 s is too slow for a motion",
    ),
    "fit of a joint at rest": (["rest.csv"], ["fit", "new.mcap"], "too-short: The motion lasts"),
    "fit of a constant torque": (["constant.csv"], ["fit", "new.mcap"], "effort 1 is 1 throughout"),
    "fit of a short recording": (["table.csv"], ["fit", "new.mcap"], "new.mcap"),
}
"""Arguments of `daq import`, then those of `ident`, and what its error holds."""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    for name, make in FILES.items():
        make(tmp_path / name)
    return tmp_path


@pytest.mark.parametrize("name", WRONG)
def test_wrong_input_is_explained(name: str, folder: Path, daq_in_process: Runner) -> None:
    line, expected = WRONG[name]
    arguments = shlex.split(line)
    output = [] if {"--out", "--guess"} & set(arguments) else OUT
    done = daq_in_process("import", *arguments, *output)
    assert done.code == 2, done.err
    assert expected in done.err
    message = [line for line in done.err.splitlines() if not line.startswith(("Usage:", "Try "))]
    assert len(message) <= 3 or "--yes" in line, done.err
    assert ";" in done.err or "--help" in done.err, "no remedy"
    assert not (folder / "new.mcap").exists()
    assert (folder / "there.mcap").read_text() == "precious"


def test_a_recording_of_ours_takes_only_what_mends_it(folder: Path, daq_in_process: Runner) -> None:
    assert daq_in_process("import", "table.csv", *OUT, *AXES).code == 0
    done = daq_in_process("import", "new.mcap", "--out", "newer.mcap", "--robot", "r7")
    assert done.code == 2
    assert "--drop-outliers, --json expected, --robot found; its rig and run are kept" in done.err
    assert not (folder / "newer.mcap").exists()


@pytest.mark.parametrize("name", AFTER)
@pytest.mark.usefixtures("folder")
def test_wrong_input_of_the_commands_after_it_is_explained(
    name: str, daq_in_process: Runner, ident_in_process: Runner
) -> None:
    imported, arguments, expected = AFTER[name]
    if imported:
        assert daq_in_process("import", *imported, *OUT, *AXES).code == 0
    done = ident_in_process(*arguments)
    assert done.code == 2, done.err
    assert expected in done.err


def test_interrupted_import_leaves_no_recording(
    folder: Path, daq_in_process: Runner, monkeypatch: pytest.MonkeyPatch
) -> None:
    def interrupted(*_: object) -> NoReturn:
        raise KeyboardInterrupt

    monkeypatch.setattr("recordings.blocks.encode", interrupted)
    done = daq_in_process("import", "table.csv", *OUT, *AXES)
    assert (done.code, done.err.strip()) == (130, "interrupted")
    assert not (folder / "new.mcap").exists()
