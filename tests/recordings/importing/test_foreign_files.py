"""Files that other people's libraries wrote give the arrays of our own recording; so its hidden effect is found."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import ident
from daq.commands.import_ import command
from recordings.reader import read
from recordings.recording import Recording
from tests.conftest import Runner
from tests.recordings.importing.foreign import FILES, KT, START, torque
from tests.running import first_fast

SAMPLES = Path(__file__).parents[3] / "recordings" / "samples"
Maker = Callable[[str], tuple[Path, list[str]]]


def proposed(file: Path, options: list[str]) -> list[str]:
    """Arguments of the command that `--guess` proposes."""
    words = [word for option in options for word in option.split()]
    result = CliRunner().invoke(command, [str(file), *words, "--guess", "--json"], catch_exceptions=False)
    guess = json.loads(result.stdout)
    assert guess["missing"] == []
    return shlex.split(guess["command"])[2:]


@pytest.mark.parametrize("kind", first_fast(FILES))
def test_proposed_command_gives_the_arrays_of_the_recording(
    kind: str, foreign_file: Maker, sample: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file, options = foreign_file(kind)
    arguments = proposed(file, options)
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    imported = read(Path(arguments[arguments.index("--out") + 1]))
    np.testing.assert_allclose(imported.time, sample.time, atol=1e-9)
    np.testing.assert_allclose(imported.position, sample.position, atol=1e-8)
    np.testing.assert_allclose(imported.effort, torque(sample), atol=1e-6)
    assert (imported.run.period, imported.run.cycles) == (sample.run.period, sample.run.cycles)
    assert (imported.run.start == START) == (kind not in ("scope CSV", "MAT")), imported.run.start


@pytest.mark.parametrize("kind", ["rosbag2 folder", "bare MCAP", "scope CSV"])
def test_ident_says_the_command_that_reads_a_foreign_file(
    kind: str, foreign_file: Maker, ident_in_process: Runner
) -> None:
    file, _ = foreign_file(kind)
    done = ident_in_process("diagnose", file)
    assert done.code == 2
    assert f"daq import {shlex.quote(str(file))} --guess" in done.err
    # The torque per ampere of the scope is missing.
    assert (f"next: daq import {shlex.quote(str(file))}" in done.err) == (kind != "scope CSV")


@pytest.mark.slow
def test_effect_hidden_in_a_drives_scope_files_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("scope-fig5a", "scope-fig5b"):
        arguments = proposed(SAMPLES / "foreign" / f"{name}.csv", ["--kt", str(KT)])
        assert CliRunner().invoke(command, arguments, catch_exceptions=False).exit_code == 0
    result = ident.diagnose(["scope-fig5a.mcap"], validate="scope-fig5b.mcap")
    assert [finding.effect for finding in result.findings if finding.effect != "rod_inertia"] == ["cogging"]
