"""Logs of candump: what `daq export` wrote comes back row by row, and what is wrong with a log is said."""

import json
import shlex
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import Result

from daq.commands.export import command as export
from daq.commands.import_ import command
from recordings.reader import read, read_can
from tests.daq.passive.listening import SAMPLE
from tests.running import DRIVES, invoke

RIG = 'name = "delta"\n[bus]\ninterface = "virtual"\n' + DRIVES


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> str:
    path = tmp_path_factory.mktemp("log") / "fig5a.log"
    invoke(export, str(SAMPLE), "--to", "candump", "--out", str(path))
    return path.read_text()


@pytest.fixture
def imported(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., Result]:
    """Import a log of this content."""
    monkeypatch.chdir(tmp_path)
    Path("rig.toml").write_text(RIG)

    def run(content: str, options: str = "--rig rig.toml") -> Result:
        Path("a.log").write_text(content)
        return invoke(command, "a.log", "--out", "a.mcap", "--json", *shlex.split(options))

    return run


def test_rows_of_our_own_export_come_back(whole: str, imported: Callable[..., Result]) -> None:
    document = json.loads(imported(whole, "--rig rig.toml --robot r7 --start 2026-01-05T08:00:00Z").stdout)
    assert document["notes"][0] == "21893 frames, 2840 SYNCs, 0 missing"
    original, back = read(SAMPLE), read(Path("a.mcap"))
    for name in ("time", "position", "voltage", "statusword", "error_code"):
        np.testing.assert_array_equal(getattr(back, name), getattr(original, name))
    one_count = 2 * np.pi / (8192 * 21)
    known = np.isfinite(original.command)  # the log shows commands before the first sample of the run, too
    np.testing.assert_allclose(back.command[known], original.command[known], atol=one_count)
    np.testing.assert_array_equal(read_can(Path("a.mcap")).data, read_can(SAMPLE).data)
    run = back.run
    assert (run.robot, run.simulated, run.cycles, run.period) == ("r7", True, 2, 4.0)
    assert run.start == "2026-01-05T08:00:00.000+00:00"


def test_one_of_several_buses_is_chosen(whole: str, imported: Callable[..., Result]) -> None:
    lines = whole.splitlines()
    both = "\n".join([*lines[:3000], *(line.replace("can0", "can1") for line in lines[3000:4000])])
    assert "several buses found: can0, can1; choose one with --topic" in str(imported(both).exception)
    assert imported(both, "--rig rig.toml --topic can0").exit_code == 0
    Path("a.mcap").unlink()
    assert "one of can0, can1 expected, 'can7' found" in str(imported(both, "--rig rig.toml --topic can7").exception)


@pytest.mark.parametrize(
    ("change", "options", "says"),
    [
        (lambda log: log, "", "daq import a.log --rig RIG.toml --out a.mcap"),
        (lambda log: log, "--rig rig.toml --map position_1=x", "daq import a.log --rig RIG.toml --out a.mcap"),
        (lambda log: log.replace(" 080#", " 0F0#"), "--rig rig.toml", "SYNCs (id 080) expected, none found"),
        (lambda log: log.replace(" 183#", " 0F3#"), "--rig rig.toml", "none of node 3 found; correct node_id"),
        (lambda log: log + "(17", "--rig rig.toml", "another line found behind"),
    ],
)
def test_what_is_wrong_with_a_log_is_said(
    change: Callable[[str], str], options: str, says: str, whole: str, imported: Callable[..., Result]
) -> None:
    log = change("\n".join(whole.splitlines()[:2000]) + "\n")
    assert says in str(imported(log, options).exception)
    assert not Path("a.mcap").exists()
