"""`ident check` as a user types it."""

import json
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest

from ident.cli import program
from ident.dynamics.effects import library
from recordings.recording import Recording
from tests.ident import building
from tests.running import invoke


@pytest.fixture(scope="module")
def file(write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("recorded") / "a.mcap"
    return write(replace(building.record(noise=0.05, encoder_step=1e-5), path=path))


@pytest.fixture(autouse=True)
def small_library(monkeypatch: pytest.MonkeyPatch) -> None:
    """A library that takes no seconds to screen."""
    names = ("stribeck", "quadratic_friction", "torque_offset", "temperature_friction")
    effects = {name: effect for name, effect in library.library().items() if name in names}
    monkeypatch.setattr(library, "library", lambda files: effects)


run = partial(invoke, program, "check")


def test_tables_name_every_effect_and_end_with_the_next_command(file: Path) -> None:
    result = run(file)
    assert result.exit_code == 0, result.output
    for text in ("SIMULATED", "250 Hz", "encoder", "\nvisible\n", "\nnot visible\n", "stribeck", "temperature_1"):
        assert text in result.stdout
    assert result.stderr.splitlines()[-1] == f"next: ident diagnose {file}"
    result = run(file, "--json", "--share", 0.5)
    document = json.loads(result.stdout)
    assert document["share"] == 0.5
    assert {"effect", "status", "joints", "confusable_with", "smallest", "why", "record", "command"} == set(
        document["effects"][0]
    )
