"""Import of files of other programs: guesses, choices, and the command that follows. `daq` itself does not run."""

import json
from pathlib import Path
from subprocess import CompletedProcess
from typing import Any

import pytest

from ident.workbench import file_import
from ident.workbench.file_import import DELTA, EXTRA, PRISMATIC, REVOLUTE, Choice, Guess
from recordings.errors import BadInput

COLUMNS = [
    {"column": "Time", "name": "time", "unit": "ms", "why": "unit in the file", "preview": [0.0, 1.0]},
    {"column": "q 1", "name": "position_1", "unit": "deg", "why": "unit in the file", "preview": [0.0, None]},
    {"column": "iq", "name": "current_1", "unit": "A", "why": "name", "preview": [1.0, 1.0]},
    {"column": "status", "name": None, "unit": None, "why": "name", "preview": []},
]


def answer(command: str = "daq import a.csv --out a.mcap", **others: Any) -> dict[str, Any]:
    return {"columns": COLUMNS, "command": command, "assumed": [], "missing": [], **others}


@pytest.fixture
def ask(monkeypatch: pytest.MonkeyPatch) -> Any:
    """Return a function that guesses with a `daq` that gives this answer."""

    def guess(document: Any, code: int = 0, stderr: str = "") -> Guess:
        done = CompletedProcess((), code, json.dumps(document), stderr)
        monkeypatch.setattr(file_import, "run_daq", lambda root, *words: done)
        return file_import.guess(Path(), "a.csv")

    return guess


def chosen(made: Guess, machine: str = DELTA, **others: Any) -> Choice:
    return Choice(tuple((c.name, c.quantity or EXTRA, c.unit) for c in made.columns), machine, **others)


def test_choice_as_guessed(ask: Any) -> None:
    made = ask(answer("daq import a.csv --out a.mcap --map time=Time:ms --map 'position_1=q 1:deg' --kt NUMBER"))
    words = file_import.arguments(made, chosen(made, torque_per_ampere=0.35), "b.mcap")
    assert words == [
        *("import", "a.csv", "--out", "b.mcap", "--map", "time=Time:ms", "--map", "position_1=q 1:deg"),
        *("--map", "current_1=iq:A", "--kt", "0.35"),
    ]
    assert made.command_options == {"--kt": "NUMBER"}
    assert made.columns[3].quantity is None


@pytest.mark.parametrize(
    ("options", "machine"),
    [
        ("", DELTA),
        (" --mechanism axes", REVOLUTE),
        (" --mechanism axes --joints prismatic", PRISMATIC),
    ],
)
def test_machine_is_that_of_the_proposed_command(options: str, machine: str, ask: Any) -> None:
    made = ask(answer(f"daq import a.csv --out a.mcap{options}"))
    assert made.machine == machine
    words = file_import.arguments(made, chosen(made, machine, torque_per_ampere=2), "b.mcap")
    assert options.split() == words[10:-2]


def test_rig_file_and_joint_names_of_a_bag(ask: Any) -> None:
    made = ask(answer("daq import bag.mcap --out b.mcap --topic /arm --names c,a,b"))
    words = file_import.arguments(made, chosen(made, "rig.toml", joint_names="a,b,c"), "b.mcap")
    assert words[-6:] == ["--rig", "rig.toml", "--topic", "/arm", "--names", "a,b,c"]


def test_unknown_torque_per_ampere_is_asked_for(ask: Any) -> None:
    made = ask(answer())
    with pytest.raises(BadInput, match=r"the torque per ampere at the joint .* expected, none found"):
        file_import.arguments(made, chosen(made), "b.mcap")
    assert not file_import.needs_torque_per_ampere({"current_1"}, "rig.toml"), "the rig file says it"
    assert not file_import.needs_torque_per_ampere({"current_1", "effort_1"}, DELTA), "it is kept, and drives nothing"


def test_two_columns_for_one_quantity_are_refused(ask: Any) -> None:
    made = ask(answer())
    with pytest.raises(BadInput, match="one column for time expected, Time and status found"):
        file_import.arguments(made, Choice((("Time", "time", "ms"), ("status", "time", "")), DELTA), "b.mcap")


def test_what_daq_refuses_is_passed_on(ask: Any) -> None:
    with pytest.raises(BadInput, match=r"^a table expected"):
        ask({}, 2, "error: a table expected, an image found; export it as CSV")


def test_warnings_come_first(monkeypatch: pytest.MonkeyPatch) -> None:
    observations = [{"level": "note", "says": "rate 250 Hz"}, {"level": "warning", "says": "time looks like ms"}] * 2
    document = {"joints": 3, "samples": 9, "duration_s": 4.0, "observations": observations, "notes": ["topic /a"]}
    done = CompletedProcess((), 0, json.dumps(document), "")
    monkeypatch.setattr(file_import, "run_daq", lambda root, *words: done)
    head, *others = file_import.convert(Path(), ["import", "a.csv"])
    assert head == "3 joints, 9 samples in 4 s"
    assert others == ["Warning: time looks like ms", "rate 250 Hz", "topic /a"]


def test_new_recording_never_has_the_name_of_another(tmp_path: Path) -> None:
    assert file_import.free_name(tmp_path, "a.csv") == "a.mcap"
    (tmp_path / "a.mcap").touch()
    assert file_import.free_name(tmp_path, "a.mcap") == "a-imported.mcap"


def test_small_plot_of_a_column() -> None:
    svg = file_import.sparkline([0.0, None, 2.0, 4.0], width=30, height=20)
    assert 'd="M0.0 18.0M20.0 10.0L30.0 2.0"' in svg, "a gap is no line"
    assert "L30.0 18.0" in file_import.sparkline([7.0, 7.0], width=30, height=20), "a constant is a line, too"
    assert file_import.sparkline([None, None]) == ""
