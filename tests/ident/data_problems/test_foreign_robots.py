"""Three foreign robots that measure their efforts: mistakes are named, and healed ones have the clean verdict."""

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, get_args

import pytest

from daq.program import program as daq
from ident.cli import program as ident
from recordings.reader import read
from tests.foreign import pairs, robots
from tests.ident.conftest import write_recording
from tests.ident.data_problems.test_mistakes import MISTAKES, Mistake
from tests.ident.data_problems.test_remedies import healed_by
from tests.running import printed

pytestmark = pytest.mark.slow

FILES = (pairs.TRAIN, pairs.VALIDATE)


@pytest.fixture(scope="module", params=[kind for kind in get_args(robots.Kind) if kind != "any"])
def clean(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with two recordings of a robot with a hidden effect."""
    folder = tmp_path_factory.mktemp("clean")
    pairs.make(folder, ("stribeck",), (0.1,), 1, pairs.Setting(request.param, signal="effort"))
    return folder


@pytest.fixture(scope="module")
def verdict(clean: Path) -> tuple[object, ...]:
    """What a diagnosis says of the clean recordings."""
    return conclusion(diagnosed(clean, FILES))


def diagnosed(folder: Path, files: Sequence[str]) -> dict[str, Any]:
    """The document of a diagnosis of two `files`."""
    train, validate = (folder / file for file in files)
    document: dict[str, Any] = json.loads(printed(ident, "diagnose", train, "--validate", validate, "--json"))
    return document


def conclusion(document: dict[str, Any]) -> tuple[object, ...]:
    """Verdict and findings."""
    return document["verdict"], sorted((each["effect"], each["joints"]) for each in document["findings"])


def spoil(clean: Path, place: Path, mistake: Mistake) -> None:
    """Write recordings with a `mistake`."""
    for file in FILES:
        write_recording(replace(mistake.change(read(clean / file)), path=place / file))


@pytest.mark.parametrize("name", [name for name, mistake in MISTAKES.items() if mistake.blocks])
def test_diagnosis_and_import_name_the_mistake_and_no_effect(name: str, clean: Path, tmp_path: Path) -> None:
    mistake = MISTAKES[name]
    spoil(clean, tmp_path, mistake)
    document = diagnosed(tmp_path, FILES)
    assert conclusion(document) == ("implausible-data", [])
    imported = json.loads(printed(daq, "import", tmp_path / pairs.TRAIN, "--out", tmp_path / "new.mcap", "--json"))
    for found in (document["data_problems"], imported["data_problems"]):
        assert {(each["kind"], *each["joints"]) for each in found} == {(mistake.kind, *mistake.joints)}


# What another test finds equal to the clean recording is not diagnosed again.
@pytest.mark.parametrize("name", ["angle within a turn", "held", "spikes"])
def test_healed_recordings_have_the_verdict_of_the_clean_ones(
    name: str, clean: Path, verdict: tuple[object, ...], tmp_path: Path
) -> None:
    spoil(clean, tmp_path, MISTAKES[name])
    if name == "spikes":
        spoiled = diagnosed(tmp_path, FILES)
        assert conclusion(spoiled) == verdict
        assert {each["kind"] for each in spoiled["data_problems"]} == {"spikes"}
    healed = [healed_by(read(tmp_path / file)).name for file in FILES]
    assert conclusion(diagnosed(tmp_path, healed)) == verdict
