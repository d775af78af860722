"""What every command does with recordings that cannot be right."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from ident.program import program
from recordings.errors import BadInput
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, robot
from tests.running import ran

run = partial(ran, program)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording, its model, and recordings in which a torque is flipped or constant."""
    folder, clean = tmp_path_factory.mktemp("recorded"), robot(3)
    write_recording(replace(clean, path=folder / "a.mcap"))
    for name, mistake in (("flipped", "flipped torque"), ("constant", "constant"), ("spikes", "spikes")):
        write_recording(replace(MISTAKES[mistake].change(clean), path=folder / f"{name}.mcap"))
    run("fit", folder / "a.mcap", "--method", "ls")
    return folder


COMMANDS = {
    "check": ["check"],
    "compare": ["compare", "a.model.json"],
    "diagnose": ["diagnose"],
    "report": ["report", "a.model.json"],
}


@pytest.mark.parametrize("command", COMMANDS)
def test_a_blocking_problem_is_the_result(command: str, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(folder)
    result = run(*COMMANDS[command], "flipped.mcap")
    assert result.stdout.startswith("Data problem (torque-sign)")
    assert result.stderr.splitlines()[-1].startswith("next: daq import flipped.mcap --out flipped-healed.mcap --map")
    assert sorted(path.name for path in folder.glob("flipped.*")) == ["flipped.mcap"]


@pytest.mark.parametrize("command", ["check", "compare", "diagnose"])
def test_one_document_says_it_even_where_nothing_can_be_fitted(
    command: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    result = run(*COMMANDS[command], "constant.mcap", "--json")
    document = json.loads(result.stdout)
    assert (document["verdict"], document["findings"], document["likely"]) == ("implausible-data", [], [])
    assert [(each["kind"], each["joints"]) for each in document["data_problems"]] == [("missing-torque", [1, 2, 3])]


def test_check_tells_the_problems_alone(folder: Path) -> None:
    documents = {
        name: json.loads(run("check", "--problems", "--json", folder / f"{name}.mcap").stdout)
        for name in ("a", "flipped", "spikes")
    }
    kinds = {name: [each["kind"] for each in document["data_problems"]] for name, document in documents.items()}
    assert kinds == {"a": [], "flipped": ["torque-sign"], "spikes": ["spikes"]}


def test_a_fit_refuses_such_data_unless_they_are_accepted(folder: Path) -> None:
    with pytest.raises(BadInput, match=r"(?s)torque-sign: .*daq import"):
        run("fit", folder / "flipped.mcap", "--method", "ls")
    accepted = run("fit", folder / "flipped.mcap", "--method", "ls", "--accept", "torque-sign", "--json")
    model = json.loads((folder / "flipped.model.json").read_text())
    kinds = [
        [each["kind"] for each in document["data_problems"]] for document in (model, json.loads(accepted.stdout))
    ]
    assert kinds == [["torque-sign"]] * 2
    compared = run("compare", folder / "flipped.model.json", folder / "flipped.mcap", "--json")
    assert [each["kind"] for each in json.loads(compared.stdout)["data_problems"]] == ["torque-sign"]


def test_spikes_are_listed_and_left_out(folder: Path) -> None:
    fitted = run("fit", folder / "spikes.mcap", "--method", "ls", "-o", folder / "s.json", "--json")
    clean = json.loads((folder / "a.model.json").read_text())
    model = json.loads(fitted.stdout)
    assert [each["kind"] for each in model["data_problems"]] == ["spikes"]
    assert model["train"]["fitted"]["rms"] == pytest.approx(clean["train"]["fitted"]["rms"], rel=0.05)
