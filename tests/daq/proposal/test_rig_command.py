"""`daq rig propose` as a user runs it, and the way from a dictionary to a model on the simulated rig."""

import os
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

from recordings.reader import read
from tests import timekeeping
from tests.conftest import Runner
from tests.drivers.simulated.dictionaries import GEAR, MADE_UP, RATED_CURRENT, RATED_TORQUE
from tests.running import free_port, served

SHARED = Path(os.environ.get("REAL_DATA", Path(__file__).parents[3].parent / "shared" / "data")) / "eds"
REAL = ("ipos.eds", "isd860.eds", "PRL120.eds", "elmo_whistle.dcf", "prbt_0_1.dcf")
NO_TORQUE = "nothing to find the torque from"
REFUSED = {"profile_only": "neither mode 8", "isd860.eds": NO_TORQUE, "outputs_only": NO_TORQUE}
TYPE_PLATE = {
    **{"counts_per_turn": "8192", "gear": "21.0", "rated_torque": f"{RATED_TORQUE * GEAR / 1000}"},
    **{"rated_current": f"{RATED_CURRENT / 1000}", "acceleration": '"counts/s^2"'},
}
"""What is asked of the user."""
REFUSES = {"wilful": "6066"}
"""An object that the drive refuses although its EDS has it: the first run says so, and how to accept it."""
UNDECIDED = {"unset_factors"}
"""Drives of which only a motion shows in what unit they count."""
CONSTANT = RATED_TORQUE / RATED_CURRENT * GEAR
"""Torque of the joint per ampere [N m/A]."""
PLATFORM = 2.033
"""Mass m_p of the simulated robot [kg]."""


def decide(rig: Path) -> None:
    """Take the decisions that a proposal leaves to its user, and fill in what nothing states."""
    text = re.sub(r"(?m)^# (accept_missing|assume_mode) =", r"\1 =", rig.read_text())
    text = re.sub(r'(\w+) = "\?"', lambda match: f"{match[1]} = {TYPE_PLATE[match[1]]}", text)
    rig.write_text(re.sub(r'per_ampere = \["\?".*\]', f"per_ampere = [{', '.join([str(CONSTANT)] * 3)}]", text))


def accept(rig: Path, index: str) -> None:
    """Accept that all drives lack one object more."""
    rig.write_text(rig.read_text().replace("[[drives]]", f'[[drives]]\naccept_missing = ["{index}"]'))


def dictionary(name: str, folder: Path) -> tuple[Path, Path]:
    """EDS and sim file of a drive."""
    if name in MADE_UP:
        return MADE_UP[name].write(folder)
    if not (SHARED / name).exists():
        pytest.skip(f"{name} is not here; set REAL_DATA")
    sim = folder / "drive.sim.toml"
    sim.write_text(f"[[drives]]\neds = {str(SHARED / name)!r}\n")
    return SHARED / name, sim


@pytest.mark.slow
@pytest.mark.parametrize("name", [*MADE_UP, *REAL])
def test_from_a_dictionary_to_a_model(
    name: str, daq: Runner, daq_in_process: Runner, ident_in_process: Runner, tmp_path: Path
) -> None:
    eds, sim = dictionary(name, tmp_path)
    proposed = daq_in_process("rig", "propose", "--eds", eds, "--bus", f"virtual:{name}")
    if name in REFUSED:
        assert proposed.code == 2
        assert REFUSED[name] in proposed.err
        return
    assert proposed.code == 0, proposed.err
    if 'in place of each "?"' in proposed.out + proposed.err:
        unfinished = daq_in_process("check", "--rig", "rig.toml", "--sim", sim)
        assert unfinished.code == 2
        assert 'is "?": nothing states it' in unfinished.err
    decide(tmp_path / "rig.toml")
    checked = daq_in_process("check", "--rig", "rig.toml", "--sim", sim)
    assert checked.code == 0, checked.out
    record = ("record", "--rig", "rig.toml", "--sim", sim, "--traj", "fig5a", "--cycles", 1, "--out")
    if name in REFUSES:
        refused = daq(*record, "refused.mcap")
        assert refused.code == 1
        assert f'accept_missing = ["{REFUSES[name]}"]' in refused.err
        accept(tmp_path / "rig.toml", REFUSES[name])
    if name in UNDECIDED:
        refused = daq_in_process(*record, "refused.mcap")
        assert refused.code == 2
        assert 'counts_source = "measured"' in refused.err
        assert daq_in_process("axis-check", "--rig", "rig.toml", "--sim", sim, "--write").code == 0
    recorded = daq(*record, "run.mcap")
    assert recorded.code == 0, recorded.err
    assert "SIMULATED" in recorded.err
    parameters = ident_in_process("fit", "run.mcap", "--json").figures["parameters"]
    values = {parameter["name"]: parameter["value"] for parameter in parameters}
    assert values["m_p"] == pytest.approx(PLATFORM, rel=0.02)


@pytest.mark.parametrize("name", ["outputs_only", "isd860.eds"])
def test_without_a_torque_positions_are_recorded(name: str, daq_in_process: Runner, tmp_path: Path) -> None:
    eds, sim = dictionary(name, tmp_path)
    propose = ("rig", "propose", "--eds", eds, "--bus", f"virtual:none-{name}")
    refused = daq_in_process(*propose)
    assert refused.code == 2
    assert "daq rig propose --torque none" in refused.err
    assert daq_in_process(*propose, "--torque", "none").code == 0
    decide(tmp_path / "rig.toml")
    assert tomllib.loads((tmp_path / "rig.toml").read_text())["drives"][0]["torque_source"] == "none"
    checked = daq_in_process("check", "--rig", "rig.toml", "--sim", sim)
    assert checked.code == 0, checked.out
    moved = daq_in_process("jog", "--joint", 1, "--by", 0.02, "--rig", "rig.toml", "--sim", sim, "--out", "jog.mcap")
    assert moved.code == 0, moved.err
    recording = read(tmp_path / "jog.mcap")
    assert recording.effort is None
    assert np.isnan(recording.voltage).all()
    assert np.isfinite(recording.position).all()


def test_an_interface_that_does_not_exist_is_refused(daq_in_process: Runner, tmp_path: Path) -> None:
    eds, _ = MADE_UP["one_millisecond"].write(tmp_path)
    done = daq_in_process("rig", "propose", "--eds", eds, "--bus", "foo:q")
    assert done.code == 2
    assert "bus.interface: one of" in done.err
    assert not (tmp_path / "rig.toml").exists()


@pytest.mark.realtime
def test_drives_on_the_bus_are_read(daq: Runner, tmp_path: Path) -> None:
    eds, _ = MADE_UP["one_millisecond"].write(tmp_path)
    bus = f"udp_multicast:239.74.163.33:{free_port()}"
    assert daq("rig", "propose", "--eds", eds, "--bus", bus, "--nodes", "5,9,12").code == 0
    decide(tmp_path / "rig.toml")
    with served(tmp_path, "--rig", "rig.toml", "--eds", eds), timekeeping.watched() as machine:
        scanned = daq("rig", "propose", "--scan", "--bus", bus, "--out", "scanned.toml")
    machine.expect(scanned.code == 0, scanned.err)
    text = (tmp_path / "scanned.toml").read_text()
    assert "values: as read from the drive" in text
    assert [drive["node_id"] for drive in tomllib.loads(text)["drives"]] == [5, 9, 12]
    assert 'torque_source = "current_actual"' in text
