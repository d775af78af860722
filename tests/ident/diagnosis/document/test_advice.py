"""Commands that a user may run after a diagnosis: they are accepted by the command line."""

import shlex
from pathlib import Path

import click
import pytest

from ident.commands.design import command as design
from ident.commands.fit import command as fit
from ident.diagnosis.diagnosis import Diagnosis
from ident.diagnosis.document.document import FindingEntry
from ident.diagnosis.document.findings import fit_command, next_motion
from ident.diagnosis.search.search import Search
from ident.diagnosis.unknown.unexplained_residual import estimate_unexplained
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building

LIBRARY = library()


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * abs(motion.velocity)


def diagnosed(train: Recording, *validate: Recording, forced: tuple[str, ...] = ("quadratic_friction",)) -> Diagnosis:
    data = building.split([train], list(validate))
    model = building.structure(train)
    effects = {name: LIBRARY[name] for name in forced}
    selection = Search(data, effects, lambda text: None).select_forced(model, building.start(model), forced)
    unexplained = estimate_unexplained(selection.model)
    return Diagnosis(data, LIBRARY, {}, selection, unexplained, None, None, True)


def found(diagnosis: Diagnosis, *alternatives: str) -> FindingEntry:
    finding = diagnosis.selection.findings[0]
    return FindingEntry.of(finding.term, finding.judgement.evidence, "", confusable_with=alternatives)


@pytest.fixture(scope="module")
def alone() -> Diagnosis:
    return diagnosed(building.record(2, noise=0.05, extra=drag, name="my file"))


def accepted(command: click.Command, text: str, *words: str) -> None:
    """Parse what follows the two words of a command, without running it."""
    assert shlex.split(text)[:2] == list(words)
    with click.Context(command) as context:
        parser = command.make_parser(context)
        parser.parse_args(shlex.split(text)[2:])


def test_effects_that_cannot_be_distinguished_ask_for_a_discriminating_motion(alone: Diagnosis) -> None:
    advice = next_motion(alone, [found(alone, "stribeck")])
    assert advice is not None
    assert "cannot distinguish quadratic_friction from stribeck" in advice.why
    words = shlex.split(advice.command)
    assert words[2:5] == ["--discriminate", "quadratic_friction", "stribeck"]
    assert words[words.index("--recording") + 1] == "my file.mcap"
    accepted(design, advice.command, "ident", "design")


def test_effect_of_a_user_brings_its_file(alone: Diagnosis) -> None:
    diagnosis = Diagnosis(**{**vars(alone), "library": {**LIBRARY, "mine": building.effect(drag)}})
    advice = next_motion(diagnosis, [found(alone, "mine")])
    assert advice is not None
    assert "--effect-file mine.py" in advice.command


def test_change_with_time_has_no_discriminating_motion(alone: Diagnosis) -> None:
    advice = next_motion(alone, [found(alone, "thermal_drift")])
    assert advice is not None
    assert "--discriminate" not in advice.command


def test_single_motion_asks_for_a_second_one(alone: Diagnosis) -> None:
    advice = next_motion(alone, [found(alone)])
    assert advice is not None
    assert "A second, different motion" in advice.why
    accepted(design, advice.command, "ident", "design")


def test_printed_commands_write_to_names_that_are_free(
    alone: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("next.toml", "my file.model.json"):
        (tmp_path / name).touch()
    advice = next_motion(alone, [found(alone)])
    assert advice is not None
    assert advice.command.endswith(" -o next2.toml")
    assert fit_command(alone, Path("curve.py"), [1]).endswith(" -o 'my file2.model.json'")


def test_two_motions_without_alternatives_need_no_third() -> None:
    other = building.record(2, noise=0.05, extra=drag, shape=1, name="other")
    diagnosis = diagnosed(building.record(2, noise=0.05, extra=drag), other)
    assert next_motion(diagnosis, [found(diagnosis)]) is None
    text = fit_command(diagnosis, Path("curve.py"), [1, 2])
    accepted(fit, text, "ident", "fit")
    assert text == (
        "ident fit bench.mcap --validate other.mcap --with quadratic_friction:1,2 --with curve:1,2 "
        "--effect-file curve.py"
    )
