"""Files that other people's libraries wrote give the arrays of our own recording; so its hidden effect is found."""

import json
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import ident
from daq.commands.import_ import command
from recordings.reader import read
from recordings.recording import Recording
from tests.recordings.importing.foreign import FILES, KT, START, torque

SAMPLES = Path(__file__).parents[3] / "recordings" / "samples"
Maker = Callable[[str], tuple[Path, list[str]]]


def proposed(file: Path, options: list[str]) -> list[str]:
    """Arguments of the command that `--guess` proposes."""
    words = [word for option in options for word in option.split()]
    result = CliRunner().invoke(command, [str(file), *words, "--guess", "--json"], catch_exceptions=False)
    guess = json.loads(result.stdout)
    assert guess["missing"] == []
    return shlex.split(guess["command"])[2:]


@pytest.mark.parametrize("kind", FILES)
def test_proposed_command_gives_the_arrays_of_the_recording(
    kind: str, foreign_file: Maker, sample: Recording, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file, options = foreign_file(kind)
    arguments = proposed(file, options)
    result = CliRunner().invoke(command, arguments, catch_exceptions=False)
    assert result.exit_code == 0
    imported = read(Path(arguments[arguments.index("--out") + 1]))
    assert imported.effort is not None
    np.testing.assert_allclose(imported.time, sample.time, atol=1e-9)
    np.testing.assert_allclose(imported.position, sample.position, atol=1e-8)
    np.testing.assert_allclose(imported.effort, torque(sample), atol=1e-6)
    assert (imported.run.period, imported.run.cycles) == (sample.run.period, sample.run.cycles)
    assert (imported.run.start == START) == (kind not in ("scope CSV", "MAT")), imported.run.start


@pytest.mark.parametrize("kind", FILES)
def test_ident_says_the_command_that_reads_a_foreign_file(kind: str, foreign_file: Maker, tmp_path: Path) -> None:
    file, _ = foreign_file(kind)
    program = "import sys; from ident.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "diagnose", str(file)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    assert f"daq import {shlex.quote(str(file))} --guess" in done.stderr
    if kind not in ("scope CSV",):  # its torque per ampere is missing
        line = next(line for line in done.stderr.splitlines() if line.startswith("next: "))
        assert shlex.split(line)[1:4] == ["daq", "import", str(file)]


@pytest.mark.slow
def test_effect_hidden_in_a_drives_scope_files_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("scope-fig5a", "scope-fig5b"):
        arguments = proposed(SAMPLES / "foreign" / f"{name}.csv", ["--kt", str(KT)])
        assert CliRunner().invoke(command, arguments, catch_exceptions=False).exit_code == 0
    result = ident.diagnose(["scope-fig5a.mcap"], validate="scope-fig5b.mcap")
    assert [finding.effect for finding in result.findings if finding.effect != "rod_inertia"] == ["cogging"]
