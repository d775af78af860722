"""`daq trajectories`."""

import json
from functools import partial
from pathlib import Path

from daq.commands.trajectories import command
from tests.running import invoke
from trajectories import names

PNG = b"\x89PNG\r\n\x1a\n"


run = partial(invoke, command)


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


def test_brackets_in_names_are_not_markup(tmp_path: Path) -> None:
    path = tmp_path / "[red]a.toml"
    path.write_text(
        'kind = "fourier"\nspace = "joint"\nperiod = 2.0\ncentre = [0, 0, 0]\n'
        "cosine = [[0.1], [0.2], [0.3]]\nsine = [[0], [0], [0]]\n"
    )
    assert "[red]a.toml" in run(path).stdout


def test_trajectory_over_a_limit_is_shown_with_the_reason(tmp_path: Path) -> None:
    rig = tmp_path / "rig.toml"
    drives = "".join(f"[[drives]]\nnode_id = {node}\n" for node in (1, 2, 3))
    rig.write_text(f'name = "slow rig"\n[limits]\nspeed = 3.0\n{drives}')
    refused = json.loads(run("fig5a", "--rig", rig, "--json").stdout)["trajectories"][0]["refused"]
    assert "speed within ±3 rad/s expected" in refused
    assert refused in run("fig5a", "--rig", rig).stdout


def test_lists_every_trajectory_and_draws_one_where_no_file_is_lost(tmp_path: Path) -> None:
    listed = run()
    assert all(name in listed.stdout for name in names())
    assert listed.stderr == "next: daq record --traj fig5a\n"
    out = tmp_path / "mine.png"
    out.write_text("mine")
    refused = run("fig5a", "--out", out)
    assert "a new name expected" in str(refused.exception)
    assert out.read_text() == "mine"
    assert run("fig5a", "--out", out, "--force").exit_code == 0
    assert out.read_bytes().startswith(PNG)
