"""Programs that the page runs, with a made-up `daq`: drives, imports, sealed truth, comparisons."""

import json
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from ident.workbench.pages.commission import _state
from ident.workbench.pages.live import run_summary
from ident.workbench.programs import file_import, recording_process
from ident.workbench.programs.file_import import DELTA, EXTRA, PRISMATIC, REVOLUTE
from ident.workbench.programs.recording_process import RecordingProcess, RunStatus
from ident.workbench.programs.running import printed_by, without_options
from ident.workbench.topics import Changes
from recordings.errors import BadInput
from tests.patience import patient

SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5b.mcap"
SIMULATED = ("daq", "record", "--traj", "fig5a")
REAL = (*SIMULATED, "--rig", "bench.toml")
SLIDE = """
name = "slide"
mechanism = "axes"
torque = {map = "linear", gain = [1.0]}
axes = [{type = "prismatic"}]
drives = [{node_id = 1}]
"""
HELD = """
import json, sys
print(json.dumps({"status": "stream", "rows": []}), flush=True)
alive = len(sys.stdin.read())
row = {"time": 0, "position": [0, alive, 0], "following_error": [0, 0.001, 0]}
print(json.dumps({"rows": [row], "argv": sys.argv}))
print(json.dumps({"released": True, "from": 0.1, "to": 0.1213, "by": 0.05}))
"""
JOG = {"--joint": "2", "--by": "0.05"}

Daq = Callable[[str], RecordingProcess]


@pytest.fixture
def daq(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Daq:
    """Return a function that gives a process whose `daq` is a program in Python; all rooms run it."""

    def start(program: str) -> RecordingProcess:
        command = (sys.executable, "-c", program)
        for module in ("running", "recording_process"):
            monkeypatch.setattr(f"ident.workbench.programs.{module}.daq_command", lambda: command)
        process = RecordingProcess(tmp_path, Changes())
        process.mark_seen()
        return process

    return start


def finished(process: RecordingProcess) -> RunStatus:
    assert process.run
    deadline = time.monotonic() + patient(60)
    while process.run.exit_code is None:
        assert time.monotonic() < deadline, "timeout"
        time.sleep(0.02)
    return process.run


def recorded(process: RecordingProcess, folder: Path, **options: str) -> RunStatus:
    process.start({f"--{name}": value for name, value in options.items()}, folder / "run.mcap")
    return finished(process)


def test_status_lines_and_text_for_people_are_told_apart(daq: Daq, tmp_path: Path) -> None:
    (tmp_path / "slide.toml").write_text(SLIDE)
    told = '{"rows": [{"time": 2.0}], "lateness": 0.5, "done": 3}'
    lines = ('{"rows": [{"time": 1.0}]}', "no JSON", "17", told)
    run = recorded(daq(f"print(*{lines!r}, sep=chr(10))"), tmp_path, rig="slide.toml")
    assert [row["time"] for row in run.rows] == [1.0, 2.0]
    assert list(run.lateness) == [(2.0, 0.5)]
    assert (run.status["done"], list(run.messages)) == (3, ["no JSON", "17"])
    assert (run.exit_code, run.position_unit) == (0, "m"), "the unit is that of the rig file"


def test_what_is_wrong_is_told_without_raw_usage(daq: Daq, tmp_path: Path) -> None:
    error = "Error: Invalid value for '--cycles': -3 is too small."
    lines = ["Usage: daq record [OPTIONS]", "Try 'daq record --help' for help.", "", error]
    run = recorded(daq(f"import sys; print(*{lines!r}, sep=chr(10), file=sys.stderr); sys.exit(2)"), tmp_path)
    assert run_summary(run) == "run.mcap: did not start. error: cycles: -3 is too small."
    (tmp_path / "bad.toml").write_text("nonsense = 1")
    process = daq("")
    with pytest.raises(BadInput, match=r"bad\.toml"):
        process.start({"--rig": "bad.toml"}, tmp_path / "run.mcap")
    for joint in ("4", "0", "1.5", ""):
        with pytest.raises(BadInput, match=f"1 to 3 expected, {joint or 'nothing'} found"):
            process.commission("jog", {**JOG, "--joint": joint})
    assert process.run is None, "nothing has started"


def test_drives_are_stopped_when_no_browser_shows_the_page(
    daq: Daq, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording_process, "_UNATTENDED_TIMEOUT", 0.3)
    run = recorded(daq("import time; time.sleep(600)"), tmp_path)
    assert run.exit_code == -signal.SIGTERM
    assert list(run.messages) == ["no browser shows the page any more: stopping"]


def test_a_jog_gets_keep_alives_until_it_is_released(daq: Daq) -> None:
    process = daq(HELD)
    process.commission("jog", JOG)
    for _ in range(3):
        process.keep_alive()
    assert process.running, "the program waits for the end of its input"
    with pytest.raises(BadInput, match="in progress"):
        process.commission("jog", JOG)
    process.release()
    run = finished(process)
    assert run.status["argv"] == ["-c", "jog", "--joint", "2", "--by", "0.05", "--hold", "--status"]
    assert run.latest("position") == 3
    assert _state(run) == (
        "daq jog: released after +0.0213 of +0.05 rad; drives off. · at +3.0000 rad, following error +1.00 mrad"
    )


def test_cycles_that_come_while_the_last_ones_are_read_do_no_harm() -> None:
    run = RunStatus(SIMULATED, None)

    class Cycle(dict[str, list[float]]):
        def get(self, key: str, default: Any = None) -> Any:  # as another thread would
            run.rows.append(Cycle(position=[9.0]))
            return super().get(key, default)

    run.rows.extend([Cycle(position=[1.0]), Cycle(position=[2.0])])
    assert run.latest("position") == 2.0


@pytest.mark.parametrize("command", ["jog", "axis-check"])
def test_a_command_that_ended_by_itself_needs_no_keep_alives(command: str, daq: Daq) -> None:
    process = daq("print('joint  follows'); print(); print('    2     100%')")
    process.commission(command, JOG)
    assert list(finished(process).messages) == ["joint  follows", "    2     100%"]
    process.keep_alive()
    process.release()


@pytest.mark.parametrize(
    ("command", "code", "message", "expected"),
    [
        (SIMULATED, 1, "error: SIGTERM received", "error: SIGTERM received. The simulated drives were disabled"),
        (REAL, 1, "error: SIGTERM received", "The drives were disabled and the file closed."),
        (REAL, 1, "error: bus-off; disabling NOT CONFIRMED", "NOT CONFIRMED."),
        (SIMULATED, -9, "", "Its simulated drives ended with it."),
        (REAL, -9, "", "CHECK THE DRIVES"),
    ],
)
def test_end_of_a_run_says_what_became_of_the_drives(
    command: tuple[str, ...], code: int, message: str, expected: str
) -> None:
    run = RunStatus(command, Path("run.mcap"), exit_code=code)
    run.messages.append(message)
    assert run_summary(run).endswith(expected) or expected in run_summary(run)


def test_error_of_ident_is_told(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match=r"^error.*missing\.json"):
        printed_by(tmp_path, "ident", "export", "missing.json", "--to", "c", "-o", "out")


def test_page_has_no_options() -> None:
    said = "a rate expected, none found; give it with --rate, or choose another file"
    assert without_options(said) == "a rate expected, none found"
    assert without_options('a.mcap is none; if another wrote it: ident.read("a.mcap")') == "a.mcap is none"
    assert without_options("To use it: ident effects --adopt law.py") == "To use it: ident effects --adopt law.py"


COLUMNS = [
    {"column": "Time", "name": "time", "unit": "ms", "why": "unit in the file", "preview": [0.0, 1.0]},
    {"column": "q 1", "name": "position_1", "unit": "deg", "why": "unit in the file", "preview": [0.0, None]},
    {"column": "iq", "name": "current_1", "unit": "A", "why": "name", "preview": [1.0, 1.0]},
    {"column": "status", "name": None, "unit": None, "why": "name", "preview": []},
]


def guessed(daq: Daq, options: str = "") -> file_import.FileGuess:
    document = {"columns": COLUMNS, "command": f"daq import a.csv --out a.mcap{options}", "missing": []}
    daq(f"print({json.dumps(document)!r})")
    return file_import.guess(Path(), "a.csv")


def chosen(made: file_import.FileGuess) -> list[tuple[str, str, str]]:
    return [(column.name, column.quantity or EXTRA, column.unit) for column in made.columns]


@pytest.mark.parametrize(
    ("proposed", "machine", "names", "options"),
    [
        ("", DELTA, "", ["--kt", "0.35"]),
        (" --mechanism axes", REVOLUTE, "", ["--mechanism", "axes", "--kt", "0.35"]),
        (
            " --mechanism axes --joints prismatic",
            PRISMATIC,
            "",
            ["--mechanism", "axes", "--joints", "prismatic", "--kt", "0.35"],
        ),
        (
            " --topic /arm --names c,a,b",
            "rig.toml",
            "a,b,c",
            ["--rig", "rig.toml", "--topic", "/arm", "--names", "a,b,c"],
        ),
    ],
)
def test_choice_as_guessed(proposed: str, machine: str, names: str, options: list[str], daq: Daq) -> None:
    made = guessed(daq, f" --map time=Time:ms --kt NUMBER{proposed}")
    assert made.machine == (machine if machine in file_import.MACHINES else DELTA)
    words = file_import.arguments(made, chosen(made), machine, "b.mcap", 0.35, names)
    mapped = ("--map", "time=Time:ms", "--map", "position_1=q 1:deg", "--map", "current_1=iq:A")
    assert words == ["import", "a.csv", "--out", "b.mcap", *mapped, *options]


def test_import_asks_for_what_no_file_says(daq: Daq) -> None:
    made = guessed(daq)
    with pytest.raises(BadInput, match=r"the torque per ampere at the joint .* expected, none found"):
        file_import.arguments(made, chosen(made), DELTA, "b.mcap")
    assert not file_import.needs_torque_per_ampere({"current_1", "effort_1"}, DELTA), "it is kept, and drives nothing"
    with pytest.raises(BadInput, match="one column for time expected, Time and status found"):
        file_import.arguments(made, [("Time", "time", "ms"), ("status", "time", "")], DELTA, "b.mcap")


def test_what_daq_says_of_an_import_is_passed_on_warnings_first(daq: Daq) -> None:
    observations = [{"level": "note", "says": "rate 250 Hz"}, {"level": "warning", "says": "time looks like ms"}] * 2
    document = {"joints": 3, "samples": 9, "duration_s": 4.0, "observations": observations, "notes": ["topic /a"]}
    daq(f"print({json.dumps(document)!r})")
    head, *others = file_import.convert(Path(), ["import", "a.csv"])
    assert head == "3 joints, 9 samples in 4 s"
    assert others == ["Warning: time looks like ms", "rate 250 Hz", "topic /a"]
    daq("import sys; sys.exit('error: a table expected, an image found; export it as CSV')")
    with pytest.raises(BadInput, match=r"^a table expected"):
        file_import.guess(Path(), "a.csv")
