"""Logs of candump: what `daq export` wrote comes back row by row, and what is wrong with a log is said."""

import json
import re
import shlex
from collections.abc import Callable, Iterable
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from daq.commands.export import command as export
from daq.commands.import_ import command
from recordings.reader import read, read_can
from tests.daq.passive.listening import SAMPLE
from tests.running import DRIVES, invoke

RIG = 'name = "delta"\n[bus]\ninterface = "virtual"\n' + DRIVES


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("log") / "fig5a.log"
    invoke(export, str(SAMPLE), "--to", "candump", "--out", str(path))
    return path.read_text()


@pytest.fixture(scope="module")
def part(whole: str) -> str:
    """The beginning of the log, with 500 samples."""
    return "".join(whole.splitlines(keepends=True)[:5000])


@pytest.fixture
def imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Import a log of this content."""
    monkeypatch.chdir(tmp_path)
    Path("rig.toml").write_text(RIG)

    def run(content: str, options: str = "--rig rig.toml") -> Result:
        Path("a.log").write_text(content)
        return invoke(command, "a.log", "--out", "a.mcap", "--json", *shlex.split(options))

    return run


def test_rows_of_our_own_export_come_back(whole: str, imported: Callable[..., Result]) -> None:
    document = json.loads(imported(whole, "--rig rig.toml --robot r7 --start 2026-01-05T08:00:00Z").stdout)
    assert document["notes"][0] == "21893 frames, 2840 SYNCs, 0 missing"
    original, back = read(SAMPLE), read(Path("a.mcap"))
    for name in ("time", "position", "voltage", "statusword", "error_code"):
        np.testing.assert_array_equal(getattr(back, name), getattr(original, name))
    one_count = 2 * np.pi / (8192 * 21)
    known = np.isfinite(original.command)  # the log shows commands before the first sample of the run, too
    np.testing.assert_allclose(back.command[known], original.command[known], atol=one_count)
    np.testing.assert_array_equal(read_can(Path("a.mcap")).data, read_can(SAMPLE).data)
    run = back.run
    assert (run.robot, run.simulated, run.cycles, run.period) == ("r7", True, 2, 4.0)
    assert run.start == "2026-01-05T08:00:00.000+00:00"


def test_one_of_several_buses_is_chosen(whole: str, imported: Callable[..., Result]) -> None:
    lines = whole.splitlines()
    both = "\n".join([*lines[:3000], *(line.replace("can0", "can1") for line in lines[3000:4000])])
    assert "several buses found: can0, can1; choose one with --topic" in str(imported(both).exception)
    assert imported(both, "--rig rig.toml --topic can0").exit_code == 0
    Path("a.mcap").unlink()
    assert "one of can0, can1 expected, 'can7' found" in str(imported(both, "--rig rig.toml --topic can7").exception)


@pytest.mark.parametrize(
    ("change", "options", "says"),
    [
        (lambda log: log, "", "daq import a.log --rig RIG.toml --out a.mcap"),
        (lambda log: log, "--rig rig.toml --map position_1=x", "daq import a.log --rig RIG.toml --out a.mcap"),
        (lambda log: log.replace(" 080#", " 0F0#"), "--rig rig.toml", r"SYNCs \(id 080\) expected, none found"),
        (lambda log: log.replace(" 183#", " 0F3#"), "--rig rig.toml", "none of node 3 found; correct node_id"),
        (
            lambda log: log + "(17\n",
            "--rig rig.toml",
            r"a.log, line 2001: a frame with its time, .*, '\(17' found",
        ),
        (
            lambda log: console(log, lambda stamp: ""),
            "--rig rig.toml",
            "line 1: a frame with its .* log with candump -l",
        ),
        (
            lambda log: console(log, AT, swapped=True),
            "--rig rig.toml",
            "line 1: .*, .*01`80' found; .* log with candump",
        ),
        (lambda log: console(log, AT).replace("  80 02", "  80"), "--rig rig.toml", "line 2: a frame"),
    ],
)
def test_what_is_wrong_with_a_log_is_said(
    change: Callable[[str], str], options: str, says: str, whole: str, imported: Callable[..., Result]
) -> None:
    log = change("\n".join(whole.splitlines()[:2000]) + "\n")
    assert re.search(says, str(imported(log, options).exception))
    assert not Path("a.mcap").exists()


def console(
    log: str,
    time: Callable[[int], str],
    direction: str = "",
    tail: Callable[[str], str] = str,
    *,
    swapped: bool = False,
) -> str:
    """What candump shows of the frames in a `log`; time: of a stamp [us]."""
    lines = []
    for line in log.splitlines():
        stamp, bus, frame = line.split()
        number, _, data = frame.partition("#")
        cells = [data[k : k + 2] for k in range(0, len(data), 2)]
        shown = "`".join(cells[::-1]) if swapped else " ".join(cells)
        seconds, _, fraction = stamp[1:-1].partition(".")
        at = time(int(seconds) * 10**6 + int(fraction))
        lines.append(
            f" {at} {bus}{direction}  {number}   [{len(cells)}]  {shown}{tail(data) if tail is not str else ''}\n"
        )
    return "".join(lines)


def since(stamp: int, digits: int = 3) -> str:
    return f"({stamp // 10**6:0{digits}d}.{stamp % 10**6:06d}) "


def step() -> Callable[[int], str]:
    """As `candump -t d`."""
    before: list[int] = []

    def of(stamp: int) -> str:
        before.append(stamp)
        return since(stamp - before[-2] if len(before) > 1 else 0)

    return of


def AT(stamp: int) -> str:
    return since(stamp + START * 10**6, 10)


def date(stamp: int) -> str:
    return f"({datetime.fromtimestamp(START + stamp // 10**6, UTC):%Y-%m-%d %H:%M:%S}.{stamp % 10**6:06d}) "


def letters(data: str) -> str:
    text = "".join(chr(byte) if 31 < byte < 127 else "." for byte in bytes.fromhex(data))
    return " " * (3 * (8 - len(data) // 2) + 3) + f"'{text}'"


def mixed(log: str, *lines: str) -> str:
    """The `log` with further lines in its middle."""
    rows = log.splitlines(keepends=True)
    now = rows[2999].split("can0")[0].strip()
    return "".join([*rows[:3000], *(f"{line}\n".replace("NOW", now) for line in lines), *rows[3000:]])


START = 1_767_600_000
FURTHER = (
    " NOW  can0  20000004   [8]  00 08 00 00 00 00 60 00   ERRORFRAME",
    "\tcontroller-problem{tx-error-warning}",
    "\terror-counter-tx-rx{{96}{0}}",
    " NOW  can0  701   [0]  remote request",
    " NOW  can0  18FF1234   [3]  11 22 33",
    " NOW  can0       702   [1]  05",
    " NOW  can0  123   {B}  11 22 33 44 55 66 77 88",
)
FD = (" NOW  can0  183  [08]  37 12 8B DF FF FF 31 1A",
      " NOW  can0  183 [0003] (45|81:00:12345678) 11 22 33",
      "DROPCOUNT: dropped 3 CAN frames on 'can0' socket (total drops 3)")  # fmt: skip
FORMS: dict[str, tuple[Callable[[str], str], str]] = {
    "-t a": (lambda log: console(log, AT), ""),
    "-t z": (lambda log: console(log, since), ""),
    "-t d": (lambda log: console(log, step()), ""),
    "-t A": (lambda log: console(log, date), ""),
    "-t a -x": (lambda log: console(log, AT, "  RX - -"), ""),
    "-t d -x -a": (lambda log: console(log, step(), "  TX B E", letters), ""),
    "-t a -a": (lambda log: console(log, AT, tail=letters), ""),
    "-t a -c": (lambda log: console(log, AT).replace("can0", "\x1b[1m\x1b[34mcan0\x1b[0m"), ""),
    "-l -x": (lambda log: log.replace("\n", " R\n"), ""),
    "DOS": (lambda log: console(log, AT).replace("\n", "\r\n"), ""),
    "nanoseconds": (lambda log: re.sub(r"(\.\d{6})\)", r"\g<1>000)", log), ""),
    "separated data": (
        lambda log: re.sub(r"(?<=#)\w+", lambda data: re.sub(r"\B(?=(\w\w)+$)", ".", data[0]), log),
        "",
    ),
    "-t a -e": (lambda log: mixed(console(log, AT), *FURTHER), ""),
    "-t a -d": (lambda log: mixed(console(log, AT), *FD), "left out: 2 frames of CAN FD, 3 frames that candump lost"),
    "cut": (lambda log: console(log, AT)[:-8], "left out: 1 line at the end, which is cut off"),
}


def assert_beginning(longer: float = 0.0) -> None:
    """What was imported is the beginning of the sample; its time may be `longer` [s]."""
    original, back = read(SAMPLE), read(Path("a.mcap"))
    rows = slice(len(back.time) - 1)  # the log ends within the last one
    assert rows.stop > 400
    for name in ("position", "statusword", "error_code"):
        np.testing.assert_array_equal(getattr(back, name)[rows], getattr(original, name)[rows])
    assert np.ptp(back.time[rows]) == pytest.approx(np.ptp(original.time[rows]) + longer, abs=5e-3)


@pytest.mark.parametrize("form", FORMS)
def test_what_a_console_shows_is_the_same_log(form: str, part: str, imported: Callable[..., Result]) -> None:
    change, note = FORMS[form]
    document = json.loads(imported(change(part)).stdout)
    assert document["notes"][1:] == ([note] if note else [])
    assert_beginning()
    if form == "-t A":
        assert read(Path("a.mcap")).run.start == "2026-01-05T08:00:00.000+00:00"
    if form == "-t a -e":
        frames = read_can(Path("a.mcap"))
        assert (frames.rtr.sum(), frames.extended.sum(), frames.error.sum()) == (1, 1, 1)
        assert frames.data[frames.error][0][1] == 8


def set_clock(log: str, changes: Iterable[tuple[int, float]]) -> str:
    """The `log` with its clock set [s] from lines on."""
    lines = log.splitlines(keepends=True)
    for first, by in changes:
        for k in range(first - 1, len(lines)):
            stamp, rest = lines[k].split(maxsplit=1)
            lines[k] = f"({float(stamp[1:-1]) + by:.6f}) {rest}"
    return "".join(lines)


@pytest.mark.parametrize(
    ("changes", "told", "longer"),
    [
        ([(4000, -3600)], r"line 4000 by -3[56]\d\d\S* s;", 0.0),
        ([(4000, -0.5)], r"line 4000 by -0\.\d+ s;", 0.0),
        ([(3000, -3), (4000, -20)], r"line 3000 by -[23]\S* s, line 4000 by -(20|19)\S* s;", 0.0),
        ([(4000, 3600)], r"line 4000 by \+3600\S* s;", 5.0),
        ([(3000, 1.7e9)], r"line 3000 by \+1\.7e\+09 s;", 5.0),
        ([(k, -9.0) for k in range(3000, 3800, 100)], r"line 3400 by -(9|8)\S* s, \.\.\.;", 0.0),
    ],
)
def test_clock_that_jumps_is_named_with_its_line(
    changes: list[tuple[int, float]], told: str, longer: float, part: str, imported: Callable[..., Result]
) -> None:
    document = json.loads(imported(set_clock(part, [(1, START), *changes])).stdout)
    assert re.search(f"the clock jumps in .*{told}", document["notes"][1])
    assert_beginning(longer)
