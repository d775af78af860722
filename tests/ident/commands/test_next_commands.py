"""Commands that are printed as what comes next run as they are, whatever exists, and replace nothing."""

import json
import shlex
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

import ident
from ident.dynamics.effects import library
from ident.program import program
from recordings.errors import BadInput
from recordings.recording import Recording
from tests.ident import building
from tests.running import ran

run = partial(ran, program)
REACHED = "all arguments were accepted"


@pytest.fixture
def folder(write: Callable[[Recording], Path], tmp_path: Path) -> Path:
    """A folder with two recordings of a machine with an effect, and a model that lacks it: a.model.json."""
    for shape, name in enumerate(("a", "b")):
        recording = building.record(noise=0.05, seed=shape, extra=lambda motion: 0.8 * motion.position, shape=shape)
        voltage = np.sign(recording.effort) * np.sqrt(np.abs(recording.effort))
        write(replace(recording, voltage=voltage, effort=None, path=tmp_path / f"{name}.mcap"))
    run("fit", tmp_path / "a.mcap", "--method", "ls")
    return tmp_path


def next_words(result: Result) -> list[str]:
    line = result.stderr.splitlines()[-1]
    assert line.startswith("next: ident ")
    return shlex.split(line)[2:]


def check_accepted(words: list[str], monkeypatch: pytest.MonkeyPatch, function: str = "diagnose") -> None:
    """The command reaches its work: no output is in its way."""

    def reached(*_: object, **__: object) -> None:
        raise BadInput(REACHED)

    assert "--force" not in words
    with monkeypatch.context() as patched:
        patched.setattr(ident, function, reached)
        with pytest.raises(BadInput, match=REACHED):
            run(*words)


def take(folder: Path, *names: str) -> None:
    for name in names:
        (folder / name).write_text("the user's")


def test_a_fit_leads_to_a_model_of_another_name(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    take(folder, "a.better.model.json")
    arguments = folder / "a.mcap", "--validate", folder / "b.mcap", "--method", "ls", "--force"
    words = next_words(run("fit", *arguments))
    assert words[words.index("-o") + 1] == str(folder / "a.better-2.model.json")
    check_accepted(words, monkeypatch)


def test_a_check_names_every_effect_and_leads_to_a_diagnosis(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    names = ("stribeck", "quadratic_friction", "torque_offset", "temperature_friction")  # all take seconds to screen
    effects = {name: library.load(name) for name in names}
    monkeypatch.setattr(library, "library", lambda files: effects)
    result = run("check", folder / "a.mcap")
    assert next_words(result) == ["diagnose", str(folder / "a.mcap")]
    for text in ("SIMULATED", "250 Hz", "encoder", "\nvisible\n", "\nnot visible\n", "stribeck", "temperature_1"):
        assert text in result.stdout
    document = json.loads(run("check", folder / "a.mcap", "--json", "--share", 0.5).stdout)
    assert document["share"] == 0.5
    keys = {"effect", "status", "joints", "confusable_with", "smallest", "why", "record", "command"}
    assert set(document["effects"][0]) == keys


def test_a_report_leads_to_a_model_beside_that_of_the_report(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    arguments = folder / "a.model.json", folder / "a.mcap", "--validate", folder / "b.mcap", "--no-diagnose"
    words = next_words(run("report", *arguments))
    assert words[words.index("-o") + 1] == str(folder / "a.better.model.json")
    check_accepted(words, monkeypatch)


def test_a_comparison_leads_to_the_recordings_of_the_fit(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    take(folder, "a.better.model.json")
    model, train, other = (folder / name for name in ("a.model.json", "a.mcap", "b.mcap"))
    words = next_words(run("compare", model, other))
    assert words[:4] == ["diagnose", str(train), "--validate", str(other)]
    check_accepted(words, monkeypatch)
    train.rename(folder / "moved.mcap")
    assert next_words(run("compare", model, other, "--force"))[:3] == ["diagnose", str(other), "--model"]


@pytest.mark.slow
def test_a_diagnosis_leads_to_a_model_and_then_to_a_report(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = (folder / "a.model.json").read_bytes()
    words = next_words(run("diagnose", folder / "a.mcap", "--validate", folder / "b.mcap", "--cutoff", 20))
    assert words[words.index("-o") + 1] == str(folder / "a.better.model.json")
    assert words[words.index("--cutoff") + 1] == "20", "the diagnosis that was shown"
    take(folder, "a.report.html")
    report = next_words(run(*words))
    assert report[:2] == ["report", str(folder / "a.better.model.json")]
    assert (folder / "a.model.json").read_bytes() == before

    # At the floor, nothing leads back to a search; console and page say the same.
    model = folder / "a.better.model.json"
    assert next_words(run("compare", model, folder / "b.mcap"))[0] == "report"
    shown = run(*report)
    assert next_words(shown)[0] == "export"
    assert "Nothing more is missing: a.better.model.json has what the base model lacks, joint_spring" in " ".join(
        shown.stdout.split()
    )
    assert "missing-effect" not in shown.stdout
    page = (folder / "a.report-2.html").read_text(encoding="utf-8")
    assert "a.better.model.json has what the base model lacks, joint_spring" in page
    assert "the held-out error falls from" not in page.partition('id="report-data"')[0]
