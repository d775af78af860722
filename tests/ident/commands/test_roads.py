"""What is printed as `next:` is followed from every command to the end of the road: no command comes twice."""

import re
import shlex
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import click
import numpy as np
import pytest

import ident.workbench.app
from daq.program import program as daq
from ident.dynamics.effects import library
from ident.program import program as ident_program
from recordings.recording import Recording
from tests.ident import building
from tests.running import ran

PROGRAMS = {"daq": daq, "ident": ident_program}
ROADS = {
    "ident check": "a.mcap",
    "ident compare": "a.model.json b.mcap",
    "ident diagnose": "a.mcap --validate b.mcap",
    "ident effects": "",
    "ident export": "a.model.json --to csv --on a.mcap -o a.csv",
    "ident fit": "a.mcap --validate b.mcap --method ls -o fitted.model.json",
    "ident methods": "",
    "ident report": "a.model.json a.mcap --validate b.mcap",
    "ident torque": "a.model.json a.mcap",
    "ident workbench": "a.mcap b.mcap --no-browser",
    "daq check": "",
    "daq export": "a.mcap --to csv",
    "daq import": "a.mcap --out again.mcap",
    "daq info": "cut.mcap",
    "daq jog": "--joint 1 --by 0.05",
    "daq recover": "cut.mcap",
    "daq trajectories": "",
}
"""Arguments of each command that runs here."""
LEADS = {
    "daq axis-check": "daq record",
    "daq home": "daq check",
    "daq record": "ident fit",
    "daq replay": "daq info",
    "daq response": "ident response",
    "daq reveal": "ident diagnose",
    "daq rig": "daq check",
    "daq sim": "daq record",
    "ident calibrate-gain": "daq record",
    "ident design": "daq record",
    "ident fleet": "ident fleet report",
    "ident response": "ident effects",
    "ident table2": "ident diagnose",
    "ident watch": "",
}
"""Where a command leads that takes longer, moves a robot, or has no robot here. Its own test runs it."""
END = "daq record"
"""A new recording is a new beginning."""
LONGEST = 8
"""Commands that lead from the first look to a model in use."""
OUTPUTS = ("-o", "--out", "--report")


@pytest.fixture
def folder(write: Callable[[Recording], Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two recordings of a machine with an effect, a model without it, and a recording that was interrupted."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(ident.workbench.app, "serve", lambda *_: None)
    for shape, name in enumerate(("a", "b")):
        _write(write, Path(f"{name}.mcap"), shape, lambda motion: 0.8 * motion.position)
    ran(ident_program, "fit", "a.mcap", "--method", "ls")
    whole = Path("a.mcap").read_bytes()
    Path("cut.mcap").write_bytes(whole[: whole.rindex(b"exit_status")])
    return tmp_path


def _write(write: Callable[[Recording], Path], path: Path, shape: int, extra: building.Torque) -> None:
    recording = building.record(noise=0.05, seed=shape, extra=extra, shape=shape)
    voltage = np.sign(recording.effort) * np.sqrt(np.abs(recording.effort))
    write(replace(recording, voltage=voltage, effort=None, path=path))


def follow(words: list[str], ended: set[str]) -> list[str]:
    """The command `words` and those that come next, as they are printed, without the names of outputs.

    ended: commands from which the road was followed to its end; the others are added.
    """
    passed: list[str] = []
    while words and " ".join(words[:2]) != END:
        names = [index + 1 for index, word in enumerate(words) if word in OUTPUTS]
        step = shlex.join(word for index, word in enumerate(words) if index not in names)
        assert step not in passed, f"a circle: {' -> '.join([*passed, step])}"
        passed.append(step)
        if step in ended:
            break
        printed = ran(PROGRAMS[words[0]], *words[1:]).output
        following = re.findall(r"next: (.*)$", printed, re.MULTILINE)
        words = [{"FILE": "b.mcap"}.get(word, word) for word in shlex.split(following[-1])] if following else []
    ended.update(passed)
    return passed


def few(monkeypatch: pytest.MonkeyPatch, *names: str) -> None:
    """Leave the library these effects, which are screened in a moment."""
    effects = {name: library.load(name) for name in names}
    monkeypatch.setattr(library, "library", lambda files=(): effects)


def test_every_command_has_its_road() -> None:
    commands = {
        f"{name} {each}" for name, group in PROGRAMS.items() for each in group.list_commands(click.Context(group))
    }
    assert ROADS.keys() | LEADS.keys() == commands
    assert not ROADS.keys() & LEADS.keys()


@pytest.mark.parametrize("start", LEADS)
def test_what_does_not_run_here_leads_to_a_command_that_does(start: str) -> None:
    seen = [start]
    while (following := LEADS.get(seen[-1], "")) not in ("", END):
        assert following not in seen
        seen.append(following)


@pytest.mark.slow
def test_every_road_ends(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    few(monkeypatch, "joint_spring", "cogging")
    ended: set[str] = set()
    given = set(folder.iterdir())
    for start, arguments in ROADS.items():
        for path in set(folder.iterdir()) - given:
            shutil.rmtree(path) if path.is_dir() else path.unlink()
        passed = follow([*start.split(), *arguments.split()], ended)
        assert len(passed) <= LONGEST, passed


@pytest.mark.slow
def test_what_nothing_explains_ends_too(
    write: Callable[[Recording], Path], folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    few(monkeypatch, "cogging")
    for shape, name in enumerate("ab"):
        _write(write, Path(f"{name}2.mcap"), shape, lambda motion: 2 * (motion.position > 0.3) * motion.velocity**2)
    passed = follow(["ident", "diagnose", "a2.mcap", "--validate", "b2.mcap"], set())
    assert any("--propose" in step for step in passed)
    assert passed[-1].startswith("ident export")
