"""Power-ups after which drives stand elsewhere: turns that encoders lost, and joints that were moved by hand.

Each is a first look at the drives, after which their poses are kept, and a second one after the change.
"""

import itertools
import os
import random
import re
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import can
import pytest

from daq.cycle.pose_memory import FOLDER
from daq.cycle.session import RunRequest, Session
from drivers.canopen import discovery
from drivers.protocol import unheard
from drivers.simulated.config import SimConfig
from drivers.simulated.rig import SimulatedRig
from recordings.errors import BadInput, RunFailed
from recordings.rig import simulated_rig
from tests.faults.campaign import Outcome
from trajectories import load

POWER_UPS = 20
_STARTED = 0x5FFF, 2
"""Object of a simulated drive by which it says that it has no other past."""
_NOT_REFUSED = "not refused"
_STEPS = 3
"""Encoder steps by which a joint that nobody touched stands elsewhere."""
_numbers = itertools.count()

Park = tuple[float, float, float]


@dataclass(frozen=True)
class PowerUp:
    """A change while the drives are off, and what the next start must say of it."""

    name: str
    reason: str
    """Regular expression of the reason that each start reports."""
    code: int
    lost: Callable[[random.Random], tuple[int, ...]] = lambda chance: (0, 0, 0)
    """Motor turns that each encoder loses."""
    by_hand: bool = False
    """Whether the robot is moved to another pose."""


def _one_turn(chance: random.Random) -> tuple[int, ...]:
    """One joint, two or all, by a turn in either direction."""
    turns = [chance.choice((-1, 0, 1)) for _ in range(3)]
    turns[chance.randrange(3)] = chance.choice((-1, 1))
    return tuple(turns)


FAULTS: tuple[PowerUp, ...] = (
    PowerUp(f"{POWER_UPS} power-ups one turn off", r"joint \d stands at .*[+-]1 turn.*--accept pose", 2, _one_turn),
    PowerUp(f"{POWER_UPS} power-ups where the joints were", _NOT_REFUSED, 1),
    PowerUp(f"{POWER_UPS} power-ups after moving by hand", _NOT_REFUSED, 1, by_hand=True),
)


def run(fault: PowerUp) -> Outcome:
    """Start `POWER_UPS` times, each from another pose."""
    ended = []
    with tempfile.TemporaryDirectory() as folder, pytest.MonkeyPatch.context() as patch:
        patch.setattr(discovery, "_LISTENING_TIME", 0.0)  # no other master is on these buses
        for seed in range(POWER_UPS):
            patch.setenv(FOLDER, str(Path(folder) / f"poses {seed}"))
            ended.append(_power_up(fault, random.Random(seed), Path(folder)))
    right = [code == fault.code and re.search(fault.reason, reason) is not None for code, reason in ended]
    code, reason = ended[0 if all(right) else right.index(False)]
    begun = not any("no answer" in reason for _, reason in ended)
    told = f"{sum(right)} of {len(right)}: {reason}"
    return Outcome(fault.name, None, None, 0, 0, code, told, True, begun and all(right), begun)


def _power_up(fault: PowerUp, chance: random.Random, folder: Path) -> tuple[int, str]:
    before, after = _somewhere(chance), _somewhere(chance)
    first = _Power(before)
    told = first.look(folder)
    assert told == (1, _NOT_REFUSED), told
    second = _Power(after if fault.by_hand else before)
    for joint, turns in enumerate(fault.lost(chance)):
        second.come_back(joint, first, turns, chance.randint(-_STEPS, _STEPS))
    return second.look(folder)


def _somewhere(chance: random.Random) -> Park:
    """A platform position [m] from which each joint may lose a turn and still stand within its limits."""
    return chance.uniform(-0.1, 0.1), chance.uniform(-0.1, 0.1), chance.uniform(-0.85, -0.75)


class _Power:
    """Drives from switching them on to switching them off."""

    def __init__(self, park: Park) -> None:
        channel = f"power-up-{os.getpid()}-{next(_numbers)}"
        rig = simulated_rig()
        self._rig = rig.model_copy(update={"bus": rig.bus.model_copy(update={"channel": channel})})
        bus = can.Bus(interface="virtual", channel=channel)
        self._machine = SimulatedRig(self._rig, SimConfig(park=park), bus, pace="realtime", seed=0)

    def come_back(self, joint: int, before: "_Power", turns: int, steps: int) -> None:
        """Be the drive that was switched off, whose encoder has lost turns, and stands a few steps elsewhere."""
        drive = self._machine.drives[joint]
        drive._objects.set(*_STARTED, before._machine.drives[joint]._objects.value(*_STARTED))
        drive._lose_turns(turns)
        drive._lost_count += steps

    def look(self, folder: Path) -> tuple[int, str]:
        """Exit code and reason of a start, which ends before the drives are set up."""
        request = RunRequest(self._rig, load("fig5b", self._rig, 1), folder / "x.mcap", "realtime", None)
        session = Session(replace(request, prepare=lambda drives: self._end(session)), unheard)
        try:
            with self._machine:
                session.run(unheard)  # type: ignore[arg-type]
        except BadInput as error:
            return 2, str(error)
        except RunFailed as error:
            return 1, str(error)
        raise AssertionError

    def _end(self, session: Session) -> None:
        """End a run where it began; its last pose is kept."""
        assert session._poses is not None
        session.progress.pose = tuple(joint.position for joint in session._poses._joints)
        raise RunFailed(_NOT_REFUSED)
