"""`daq trajectories`."""

import json
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from daq.commands.trajectories import command
from recordings.errors import BadInput
from tests.running import invoke
from trajectories import names

PNG = b"\x89PNG\r\n\x1a\n"


run = partial(invoke, command)


def test_lists_every_trajectory() -> None:
    result = run()
    assert result.exit_code == 0
    for name in names():
        assert name in result.stdout
    assert result.stderr == "next: daq record --traj fig5a\n"


def test_json_is_one_document_with_the_figures() -> None:
    result = run("--json", "--cycles", "2")
    assert result.stderr == ""
    document = json.loads(result.stdout)
    assert document["schema"] == 1
    assert [entry["name"] for entry in document["trajectories"]] == list(names())
    fig5a = document["trajectories"][names().index("fig5a")]
    assert fig5a["duration_s"] == 10.0
    assert (fig5a["period_s"], fig5a["cycles"], fig5a["rate_hz"]) == (4.0, 2, 500.0)
    assert all(2 < speed < 12 for speed in fig5a["max_speed_rad_s"])
    assert fig5a["refused"] is None


def test_draws_a_png(tmp_path: Path) -> None:
    out = tmp_path / "fig5a.png"
    result = run("fig5a", "--out", out)
    assert result.exit_code == 0
    assert out.read_bytes().startswith(PNG)


def test_existing_file_is_kept_unless_forced(tmp_path: Path) -> None:
    out = tmp_path / "mine.png"
    out.write_text("mine")
    result = run("fig5a", "--out", out)
    assert isinstance(result.exception, BadInput)
    assert "exists; choose another name or add --force" in str(result.exception)
    assert out.read_text() == "mine"
    assert run("fig5a", "--out", out, "--force").exit_code == 0
    assert out.read_bytes().startswith(PNG)


def test_brackets_in_names_are_not_markup(tmp_path: Path) -> None:
    path = tmp_path / "[red]a.toml"
    path.write_text(
        'kind = "fourier"\nspace = "joint"\nperiod = 2.0\ncentre = [0, 0, 0]\n'
        "cosine = [[0.1], [0.2], [0.3]]\nsine = [[0], [0], [0]]\n"
    )
    assert "[red]a.toml" in run(path).stdout


def test_other_formats_are_refused(tmp_path: Path) -> None:
    result = run("fig5a", "--out", tmp_path / "fig5a.jpg")
    assert isinstance(result.exception, BadInput)
    assert "ending in .png expected" in str(result.exception)


def test_drawing_needs_a_name(tmp_path: Path) -> None:
    result = run("--out", tmp_path / "all.png")
    assert result.exit_code == 2
    assert "name it" in result.stderr


def test_trajectory_over_a_limit_is_shown_with_the_reason(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
    rig.write_text(f'name = "slow rig"\n[limits]\nspeed = 3.0\n{drives}')
    refused = json.loads(run("fig5a", "--rig", rig, "--json").stdout)["trajectories"][0]["refused"]
    assert "speed within ±3 rad/s expected" in refused
    assert refused in run("fig5a", "--rig", rig).stdout


@pytest.mark.parametrize("arguments", [["fig6"], ["fig5a", "--rig", "none.toml"], ["none.csv"]])
def test_bad_input_is_reported_without_traceback(arguments: list[str], tmp_path: Path) -> None:
    program = "from daq.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", program, "trajectories", *arguments], capture_output=True, text=True, cwd=tmp_path
    )
    assert done.returncode == 2
    assert done.stderr.startswith("error: ")
    assert "Traceback" not in done.stderr
    assert done.stdout == ""


def test_help_imports_nothing_heavy() -> None:
    program = (
        "import sys, daq.commands.trajectories; "
        "print([name for name in ('numpy', 'scipy', 'matplotlib', 'pydantic') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
