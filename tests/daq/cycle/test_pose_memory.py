"""Memory of poses: a joint that comes back whole motor turns off is refused, one that sank or is another is not."""

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from daq.cycle.pose_memory import FOLDER, PoseMemory
from drivers.protocol import Identity
from recordings.errors import BadInput
from recordings.rig import Rig, load_rig, simulated_rig
from tests import timekeeping
from tests.conftest import Runner
from tests.running import DRIVES, served, udp_bus

RIG = simulated_rig()
DRIVE = RIG.drives[0]
TURN = 2 * math.pi / DRIVE.gear
"""Of the motor, at the joint [rad]."""
NEW = Identity(1, "node 1", "drive", 0xAB, 0xCD, 1, simulated=False, lockstep=False)


@pytest.fixture(autouse=True)
def poses(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of this test."""
    folder = tmp_path_factory.mktemp("poses")
    monkeypatch.setenv(FOLDER, str(folder))
    return folder


def at(position: float | None, identity: Identity = NEW, rig: Rig = RIG) -> PoseMemory:
    return PoseMemory(rig, [replace(identity, position=position)])


@pytest.mark.parametrize("turns", [k + part for k in (-2, -1, 1, 2, 3) for part in (-0.045, -0.01, 0.0, 0.03)])
def test_whole_turns_are_refused_with_both_poses(turns: float) -> None:
    at(0.02).keep([0.02])
    here = at(0.02 + turns * TURN)
    with pytest.raises(BadInput, match=rf"{0.02 + turns * TURN:.4f} rad, 0\.0200 rad when .* --accept pose"):
        here.check()
    here.check(frozenset({"pose"}))


@pytest.mark.parametrize("turns", [0, 0.04, *(k + part for k in (-2, -1, 0, 1, 2, 3) for part in (0.07, 0.5, 0.93))])
def test_an_arm_that_sank_is_not_refused(turns: float) -> None:
    at(0.02).keep([0.02])
    at(0.02 + turns * TURN).check()


@pytest.mark.parametrize(
    "change",
    [{"serial_number": 7}, {"address": "node 2"}, {"started": 5, "simulated": True}, {"lockstep": True}],
    ids=["another drive", "another node", "a simulated drive started again", "in lockstep"],
)
def test_another_drive_has_another_past(change: dict[str, object]) -> None:
    at(0.0).keep([0.0])
    at(TURN, replace(NEW, **change)).check()  # type: ignore[arg-type]


def test_the_drive_is_known_by_its_serial_number_not_by_its_node() -> None:
    drive = replace(NEW, serial_number=7)
    at(0.0, drive).keep([0.0])
    with pytest.raises(BadInput, match=r"-1 turn"):
        at(-TURN, replace(drive, address="node 9")).check()


def test_a_corrected_zero_is_no_lost_turn() -> None:
    """The counts of the encoder are compared, not the angles of the joint."""
    at(0.0).keep([0.0])
    moved = RIG.model_copy(update={"drives": (DRIVE.model_copy(update={"zero_offset": TURN}), *RIG.drives[1:])})
    at(TURN, rig=moved).check()


def test_outside_the_limits_nothing_is_accepted() -> None:
    with pytest.raises(BadInput, match=r"outside -1\.2 to 1\.4 rad"):
        at(RIG.limits.joint_max + 0.1).check(frozenset({"pose"}))


@pytest.mark.parametrize("text", ["", "[]", '{"counts": "a"}', '{"counts": 3.5, "started": 0}'])
def test_a_damaged_file_is_no_memory(text: str, poses: Path) -> None:
    at(0.0).keep([0.0])
    (file,) = poses.iterdir()
    assert json.loads(file.read_text())["counts"] == 0
    file.write_text(text)
    at(TURN).check()


@pytest.fixture
def sim(tmp_path: Path) -> Iterator[str]:
    """A simulated rig that loses turns between two runs; its rig file."""
    limits = "[limits]\nsilence = 0.5\nhost_stall = 1.0\n"
    (tmp_path / "rig.toml").write_text(f'name = "bench"\nrate = 100\n{limits}{udp_bus()}{DRIVES}')
    with served(tmp_path, "--rig", "rig.toml", "--habit", "turns_off=1"):
        yield "rig.toml"


def jog(sim: str) -> tuple[object, ...]:
    return ("jog", "--joint", 1, "--by", 0.02, "--speed", 0.1, "--rig", sim)


@pytest.mark.realtime
def test_a_lost_turn_is_refused_before_anything_moves(daq_in_process: Runner, sim: str, poses: Path) -> None:
    drives = daq_in_process("check", "--rig", sim, "--json").figures["drives"]
    memory = PoseMemory(load_rig(Path(sim)), [Identity(**drive) for drive in drives])
    memory.keep([drive["position"] - TURN for drive in drives])
    refused = daq_in_process(*jog(sim))
    assert refused.code == 2
    assert "+1 turn" in refused.err
    checked = daq_in_process("check", "--rig", sim, "--json")
    assert checked.code == 1
    assert checked.out, checked.err
    rows = [row for row in json.loads(checked.out)["findings"] if row["what"] == "pose"]
    assert [row["verdict"] for row in rows] == ["problem"] * 3
    assert str(poses) in rows[0]["expected"]


@pytest.mark.realtime
def test_the_pose_of_each_run_is_kept_and_a_refusal_changes_nothing(daq_in_process: Runner, sim: str) -> None:
    with timekeeping.watched() as machine:
        runs = [daq_in_process(*jog(sim), *accepted) for accepted in ((), (), (), ("--accept", "pose"), ())]
    machine.expect(all(done.code != 1 for done in runs), "".join(done.err for done in runs))
    assert [done.code for done in runs] == [0, 2, 2, 0, 0]
