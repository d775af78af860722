"""Memory of poses: a joint that comes back whole motor turns off is refused, one that sank or is another is not."""

import json
import math
import random
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from daq.cycle.pose_memory import FOLDER, PoseMemory
from drivers.protocol import Identity, unheard
from recordings.errors import BadInput
from recordings.rig import Rig, load_rig, simulated_rig
from tests import timekeeping
from tests.conftest import Runner
from tests.drivers.serial import script as serial_script
from tests.drivers.serial.script import FLUSH, drives
from tests.drivers.serial.test_setup import found
from tests.running import DRIVES, served, udp_bus

SERIAL, TURN_OF_LINE = serial_script.RIG, 1.0
RIG = simulated_rig()
DRIVE = RIG.drives[0]
TURN = 2 * math.pi / DRIVE.gear
"""Of the motor, at the joint [rad]."""
STEP = TURN / DRIVE.counts_per_turn
"""Of the encoder, at the joint [rad]."""
REST = 548 * STEP
"""A pose [rad]: encoders know whole steps only."""
NEW = Identity(1, "node 1", "drive", 0xAB, 0xCD, 1, simulated=False, lockstep=False)


@pytest.fixture(autouse=True)
def poses(tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of this test."""
    folder = tmp_path_factory.mktemp("poses")
    monkeypatch.setenv(FOLDER, str(folder))
    return folder


def at(*position: float | None, identity: Identity = NEW, rig: Rig = RIG) -> PoseMemory:
    """Joints that stand there [rad]."""
    joints = [replace(identity, joint=j, address=f"node {j}", position=q) for j, q in enumerate(position, start=1)]
    return PoseMemory(rig, joints)


def kept(*position: float) -> None:
    at(*position).keep(position, unheard)


def with_drive(**change: object) -> Rig:
    return RIG.model_copy(update={"drives": (DRIVE.model_copy(update=change), *RIG.drives[1:])})


def is_refused(memory: PoseMemory) -> bool:
    try:
        memory.check()
    except BadInput:
        return True
    return False


@pytest.mark.parametrize("turns", [-2, -1, 1, 2, 3])
@pytest.mark.parametrize("steps", [-8, -3, 0, 1, 8])
def test_whole_turns_are_refused_with_both_poses(turns: int, steps: int) -> None:
    kept(REST)
    here = REST + turns * TURN + steps * STEP
    words = f"joint 1 stands at {here:.4f} rad, 0.0200 rad when it was last seen: {turns:+d} turn"
    with pytest.raises(BadInput, match=rf"^{re.escape(words)}.* --accept pose if it has$"):
        at(here).check()
    at(here).check(frozenset({"pose"}))


@pytest.mark.parametrize("steps", [0, 8, *(8192 * k + d for k in (-2, -1, 0, 1, 2, 3) for d in (-10, 10, 400, 4096))])
def test_an_arm_that_sank_or_was_moved_is_not_refused(steps: int) -> None:
    kept(REST)
    at(REST + steps * STEP).check()


@pytest.mark.parametrize(
    ("change", "refused"),
    [
        ((1, 0, 0), True),
        ((-1, 0, 2), True),
        ((1, 1, 1), True),
        ((1, 0.0006, -0.0006), True),
        ((0, 0, 0), False),
        ((1, 0.01, 0), False),
        ((1, 2.3, -0.4), False),
        ((0.5, 0, 0), False),
    ],
)
def test_the_other_joints_stand_whole_turns_from_where_they_were_too(
    change: tuple[float, ...], refused: bool
) -> None:
    kept(REST, -3000 * STEP, 0.0)
    memory = at(*(q + turns * TURN for q, turns in zip((REST, -3000 * STEP, 0.0), change, strict=True)))
    assert is_refused(memory) is refused
    problems = [row.verdict == "problem" for row in memory.results()]
    assert problems == [refused and round(turns) != 0 for turns in change]


def test_joints_that_nothing_is_known_of_are_no_witnesses() -> None:
    kept(REST)
    assert is_refused(at(REST + TURN, 0.3, None))


@pytest.mark.parametrize(("joints", "alarms"), [(1, 7), (3, 0)])
def test_moved_by_hand_is_seldom_taken_for_a_lost_turn(joints: int, alarms: int) -> None:
    """One alone: 17 of 8192 steps stand near a whole turn. All of a delta robot move together."""
    chance, trials = random.Random(5), 4000
    kept(*(REST for _ in range(joints)))
    poses = ([chance.uniform(-1.1, 1.3) for _ in range(joints)] for _ in range(trials))
    assert sum(is_refused(at(*pose)) for pose in poses) == alarms


@pytest.mark.parametrize(("counts_per_turn", "steps"), [(2000, 4), (8192, 8), (2**20, 1048)])
def test_a_fine_encoder_may_slip_by_more_of_its_steps(counts_per_turn: int, steps: int) -> None:
    rig = with_drive(counts_per_turn=counts_per_turn)
    at(0.0, rig=rig).keep([0.0], unheard)
    for slip in (steps, steps + 1):
        memory = at(rig.drives[0].to_position(counts_per_turn + slip), rig=rig)
        assert is_refused(memory) is (slip == steps)


@pytest.mark.parametrize(
    ("before", "after", "words"),
    [
        (2.25, 0.25, "as of a single-turn encoder: home it after every power-up"),
        (-1.75, 0.25, "as of a single-turn encoder: home it after every power-up"),
        (2.25, 1.25, "as of an encoder that lost count while off"),
        (0.25, 1.25, "as of an encoder that lost count while off"),
        (2.25, 2.25, "where it was, as of a multi-turn encoder or a drive that stayed on"),
        (0.25, 0.25, "where it was"),
        (0.25, 0.75, "moved since"),
    ],
)
def test_what_a_pose_looks_like_is_said(before: float, after: float, words: str) -> None:
    """In motor turns from the zero of the encoder."""
    kept(before * TURN)
    (row,) = at(after * TURN).results()
    assert row.found.endswith(words)
    assert row.found.startswith(f"{after * TURN:.4f} rad, {before * TURN:.4f} rad when it was last seen: ")
    assert row.verdict == ("problem" if "of a single" in words or "lost" in words else "fine")


@pytest.mark.parametrize(
    ("position", "words"),
    [(0.1, "0.1000 rad; no last pose with this zero"), (None, "angle not told, or without zero reference; no last")],
)
def test_without_a_last_pose_the_angle_is_shown_and_noted(position: float | None, words: str) -> None:
    (row,) = at(position).results()
    assert (row.what, row.verdict) == ("absolute zero", "noted")
    assert row.found.startswith(words)


def test_without_a_folder_no_pose_is_kept_which_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(FOLDER, "")
    kept(0.0)
    (row,) = at(TURN).results()
    assert (row.found, row.verdict) == (f"{TURN:.4f} rad; no pose is kept", "accepted")
    assert FOLDER in row.expected


def test_a_pose_that_cannot_be_kept_is_warned_of(monkeypatch: pytest.MonkeyPatch, poses: Path) -> None:
    (poses / "file").write_text("")
    monkeypatch.setenv(FOLDER, str(poses / "file" / "below"))
    said: list[str] = []
    at(0.0).keep([0.0], lambda level, source, text: said.append(f"{level} {source}: {text}"))
    assert len(said) == 1
    assert said[0].startswith("warning joint 1: its last pose is not kept: ")


@pytest.mark.parametrize(
    "change",
    [{"serial_number": 7}, {"started": 5, "simulated": True}, {"lockstep": True}],
    ids=["another drive", "a simulated drive started again", "in lockstep"],
)
def test_another_drive_has_another_past(change: dict[str, Any]) -> None:
    kept(0.0)
    at(TURN, identity=replace(NEW, **change)).check()


def test_the_drive_is_known_by_its_serial_number_not_by_its_node() -> None:
    drive = replace(NEW, serial_number=7)
    PoseMemory(RIG, [replace(drive, position=0.0)]).keep([0.0], unheard)
    with pytest.raises(BadInput, match=r"-1 turn"):
        PoseMemory(RIG, [replace(drive, address="node 9", position=-TURN)]).check()
    PoseMemory(RIG, [replace(NEW, address="node 9", position=-TURN)]).check()


@pytest.mark.parametrize(
    "change", [{"zero_offset": 1e-3}, {"gear": 20.0}, {"counts_per_turn": 4096}, {"sign": -1}], ids=str
)
def test_the_memory_begins_anew_with_another_zero_gear_or_sign(change: dict[str, object]) -> None:
    kept(0.0)
    assert is_refused(at(TURN))
    memory = at(TURN, rig=with_drive(**change))
    memory.check()
    assert [row.verdict for row in memory.results()] == ["noted"]
    memory.keep([TURN], unheard)
    at(TURN, rig=with_drive(**change)).check()


def test_outside_the_limits_nothing_is_accepted() -> None:
    outside = at(RIG.limits.joint_max + 0.1)
    with pytest.raises(BadInput, match=r"outside -1\.2 to 1\.4 rad"):
        outside.check(frozenset({"pose"}))
    assert [row.verdict for row in outside.results()] == ["problem"]


@pytest.mark.parametrize("text", ["", "[]", '{"counts": "a"}', '{"counts": 3.5, "started": 0}'])
def test_a_damaged_file_is_no_memory(text: str, poses: Path) -> None:
    kept(0.0)
    (file,) = poses.iterdir()
    document = json.loads(file.read_text())
    assert (document["counts"], document["gear"]) == (0, 21.0)
    file.write_text(text)
    at(TURN).check()
    file.write_text(json.dumps(document | {"counts": 3.5}))
    at(3.5 * STEP + TURN).check()


def test_drives_on_a_serial_line_have_a_memory_too() -> None:
    """They tell no serial number: the name of the rig and their place on the line do."""
    replies = [FLUSH, *(pair for node in (1, 2, 3) for pair in found(node))]
    amplifiers, _, _ = drives(replies * 2, SERIAL)
    identities = amplifiers.discover()
    PoseMemory(SERIAL, identities).keep([TURN_OF_LINE, 0.5, 0.0], unheard)
    with pytest.raises(BadInput, match=r"joint 1 stands at 0.0000 rad, 1.0000 rad when .* -1 turn"):
        PoseMemory(SERIAL, amplifiers.discover()).check()


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
    memory.keep([drive["position"] - TURN for drive in drives], unheard)
    refused = daq_in_process(*jog(sim))
    assert refused.code == 2
    assert "+1 turn" in refused.err
    checked = daq_in_process("check", "--rig", sim, "--json")
    assert checked.code == 1
    assert checked.out, checked.err
    rows = [row for row in json.loads(checked.out)["findings"] if row["what"] == "absolute zero"]
    assert [row["verdict"] for row in rows] == ["problem"] * 3
    assert str(poses) in rows[0]["expected"]


@pytest.mark.realtime
def test_the_pose_of_each_run_is_kept_and_a_refusal_changes_nothing(daq_in_process: Runner, sim: str) -> None:
    with timekeeping.watched() as machine:
        runs = [daq_in_process(*jog(sim), *accepted) for accepted in ((), (), (), ("--accept", "pose"), ())]
    machine.expect(all(done.code != 1 for done in runs), "".join(done.err for done in runs))
    assert [done.code for done in runs] == [0, 2, 2, 0, 0]
    said = "joint 3 (node 3): absolute zero: "
    for done, words in ((runs[0], "no last pose"), (runs[3], "+1 turn(s)"), (runs[4], "where it was")):
        (line,) = [line for line in done.err.splitlines() if said in line]
        assert words in line
        assert line.startswith("info" if done is runs[4] else "warning")


def test_drives_that_all_have_one_serial_number_are_known_by_their_nodes(poses: Path) -> None:
    same = replace(NEW, serial_number=0x55)
    at(REST, REST + TURN, REST, identity=same).keep((REST, REST + TURN, REST), unheard)
    assert len(list(poses.iterdir())) == 3
    assert is_refused(at(REST, REST, REST, identity=same))
