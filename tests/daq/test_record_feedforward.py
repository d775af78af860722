"""`daq record --feedforward` as a user runs it."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from daq.commands.record import command
from recordings.errors import BadInput
from recordings.reader import read
from recordings.rig import simulated_rig
from tests.conftest import Runner
from tests.daq.feedforward.given import write_nominal_torque
from tests.running import printed
from trajectories import load

SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "fig5a.mcap"
MOTION = ("--traj", "fig5b", "--cycles", 1, "--rate", 100)
RIG = "name = 'r'\n{section}\n" + "".join(f"[[drives]]\nnode_id = {i}\n{{keys}}\n" for i in (1, 2, 3))


@pytest.mark.parametrize(
    ("section", "keys", "message"),
    [
        ("", 'mode = "interpolated"', "mode 7 has no 60B2h"),
        ("[limits]\ntorque = 15.0", "", "limits.torque"),
        (
            '[bus]\ntransport = "serial"\nbaud = 460800',
            "",
            "joint 1: a torque can be fed forward only to a drive with",
        ),
    ],
)
def test_rig_that_cannot_be_fed_forward_is_refused_before_anything_is_opened(
    tmp_path: Path, section: str, keys: str, message: str
) -> None:
    rig, table, out = tmp_path / "rig.toml", tmp_path / "t.csv", tmp_path / "run.mcap"
    rig.write_text(RIG.format(section=section, keys=keys))
    description = simulated_rig().at_rate(60.0)
    write_nominal_torque(table, load("fig5b", description, 1), description)
    options = ("--traj", "fig5b", "--cycles", 1, "--rate", 60, "--out", out)
    with pytest.raises(BadInput, match=message):
        printed(command, *options, "--rig", rig, "--feedforward", table)
    with pytest.raises(BadInput, match="--accept belongs to --feedforward"):
        printed(command, *options, "--accept", "assumed-gain")
    assert not out.exists()


@pytest.mark.slow
def test_model_is_fed_forward_by_name_of_its_file(daq: Runner, ident: Runner, tmp_path: Path) -> None:
    (tmp_path / "sim.toml").write_text("[servo]\nexact_reference = true\n")
    assert ident("fit", SAMPLE, "--method", "svd", "-o", "m.json").code == 0
    assert daq("record", *MOTION, "--sim", "sim.toml", "--out", "plain.mcap").code == 0
    fed = daq("record", *MOTION, "--sim", "sim.toml", "--feedforward", "m.json", "--out", "fed.mcap")
    assert fed.code == 0, fed.err
    figures = {name: json.loads(daq("info", f"{name}.mcap", "--json").out) for name in ("plain", "fed")}
    assert figures["plain"]["feedforward"] is None
    assert figures["fed"]["feedforward"] == hashlib.sha256((tmp_path / "m.json").read_bytes()).hexdigest()
    errors = {name: np.array(values["following_error_rms"]) for name, values in figures.items()}
    assert (errors["fed"] < 0.5 * errors["plain"]).all()
    recording = read(tmp_path / "fed.mcap")
    assert any("table SHA-256" in event.message for event in recording.events)
    assert np.nanmax(recording.numbered("torque_offset")) > 5
    (tmp_path / "rig.toml").write_text(RIG.format(section="[geometry]\nL1 = 0.33", keys=""))
    other = daq("record", *MOTION, "--rig", "rig.toml", "--feedforward", "m.json", "--out", "other.mcap")
    assert other.code == 2
    assert "geometry.L1 is 0.3423 in the model, 0.33 in" in other.err
