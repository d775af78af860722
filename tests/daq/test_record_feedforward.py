"""`daq record --feedforward` as a user runs it."""

import hashlib
import json
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read
from tests.conftest import Runner

SAMPLE = Path(__file__).parents[2] / "recordings" / "samples" / "fig5a.mcap"
MOTION = ("--traj", "fig5b", "--cycles", 1, "--rate", 100)
RIG = "name = 'r'\n{section}\n" + "".join(f"[[drives]]\nnode_id = {i}\n{{keys}}\n" for i in (1, 2, 3))


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
