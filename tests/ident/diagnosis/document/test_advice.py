"""Commands that a user may run after a diagnosis: they are accepted by the command line."""

import shlex
from pathlib import Path
from typing import Any

import click
import pytest

from ident.commands.design import command as design
from ident.commands.fit import command as fit
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import FindingEntry
from ident.diagnosis.document.findings import fit_command, next_motion
from ident.diagnosis.unknown.residual_test import estimate_unexplained
from ident.dynamics.effects.library import library
from recordings.recording import Recording
from tests.ident import building

LIBRARY = {**library(), "mine": building.effect(building.drag)}


def diagnosed(*validate: Recording, name: str) -> Diagnosis:
    """Recordings with drag, to which the effect that is planted was added."""
    data = building.split([building.record(2, noise=0.05, extra=building.drag, name=name)], validate)
    search, begin = building.search(data, {"quadratic_friction": LIBRARY["quadratic_friction"]})
    selection = search.select_forced(*begin, ["quadratic_friction"])
    absent: Any = None
    return Diagnosis(data, LIBRARY, absent, selection, estimate_unexplained(selection.model), None, absent, None)


def found(diagnosis: Diagnosis, *alternatives: str) -> FindingEntry:
    finding = diagnosis.selection.findings[0]
    return FindingEntry.of(finding.term, finding.judgement.evidence, "", confusable_with=alternatives)


def is_accepted(command: click.Command, text: str) -> bool:
    """Whether `command` takes what follows its two words, without running it."""
    words = shlex.split(text)
    with click.Context(command) as context:
        command.make_parser(context).parse_args(words[2:])
    return words[0] == "ident"


@pytest.fixture(scope="module")
def alone() -> Diagnosis:
    return diagnosed(name="my file")


@pytest.mark.parametrize(
    ("alternatives", "why", "options"),
    [
        (["stribeck"], "cannot distinguish quadratic_friction from stribeck", "--discriminate quadratic_friction"),
        (["mine"], "cannot distinguish", "--effect-file mine.py"),
        (
            ["thermal_drift"],
            "A second, different motion",
            "--recording 'my file.mcap'",
        ),
        ([], "A second, different motion", "--recording 'my file.mcap'"),
    ],
)
def test_next_motion_tells_apart_what_can_be_told_apart(
    alone: Diagnosis, alternatives: list[str], why: str, options: str
) -> None:
    advice = next_motion(alone, [found(alone, *alternatives)])
    assert advice is not None
    assert why in advice.why
    assert options in advice.command
    assert ("--discriminate" in advice.command) == ("distinguish" in advice.why)
    assert is_accepted(design, advice.command)


def test_printed_commands_write_to_names_that_are_free(
    alone: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "next.toml").touch()
    advice = next_motion(alone, [found(alone)])
    assert advice is not None
    assert advice.command.endswith(" -o next-2.toml")


def test_two_motions_without_alternatives_need_no_third() -> None:
    other = building.record(2, noise=0.05, extra=building.drag, shape=1, name="other")
    diagnosis = diagnosed(other, name="bench")
    assert next_motion(diagnosis, [found(diagnosis)]) is None
    text = fit_command(diagnosis, Path("curve.py"), [1, 2])
    assert is_accepted(fit, text)
    assert text == (
        "ident fit bench.mcap --validate other.mcap --with quadratic_friction:1,2 --with curve:1,2 "
        "--effect-file curve.py"
    )
