"""Cases of the simulated rig, recorded through its bus in lockstep."""

import os
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.hidden_effects.cases import HiddenCase, RobotName
from daq.cycle.session import RunRequest, Session
from daq.simulation import simulated
from drivers.simulated.config import ROBOTS, EffectSpec, SimConfig, load_sim
from drivers.simulated.hidden import draw
from drivers.simulated.seal import truth
from drivers.simulated.sizing import EffectSizer
from recordings.buses import CanBus
from recordings.rig import Rig, Voltage, simulated_rig
from trajectories import load

_SLOW = ("thermal_drift", "payload_change")
"""Effects that need more cycles to be visible."""


def record(case: HiddenCase, folder: Path) -> dict[str, Any]:
    """Write train.mcap and validate.mcap into `folder`; return the truth.

    Raises:
        BadInput: an effect cannot have its size on this robot.
    """
    rig = _rig(case)
    base_config = _machine(case.robot)
    config = base_config.model_copy(update={"voltage_noise": case.volts, "effects": _effects(case)})
    train_cycles = 5 if set(case.effects) & set(_SLOW) else 4
    for index, (name, motion, cycles) in enumerate((("train", "fig5a", train_cycles), ("validate", "fig5b", 3))):
        out = folder / f"{name}.mcap"
        seed = 2 * case.seed + index
        request = RunRequest(rig=rig, trajectory=load(motion, rig, cycles), out=out, pace="lockstep", seed=seed)
        with simulated(rig, config, "lockstep", seed):
            Session(request, lambda *_: None).run(lambda _: nullcontext())
    return truth(rig, config, case.seed, _sizer(case.robot, case.reports_command) if case.effects else None)


def _effects(case: HiddenCase) -> tuple[EffectSpec, ...]:
    drawn: tuple[EffectSpec, ...] = ()
    for effect, size in zip(case.effects, case.sizes, strict=True):
        sizer = _sizer(case.robot, case.reports_command)
        base_config = _machine(case.robot)
        drawn += draw(
            case.seed, _base_rig(case.reports_command), base_config, names=[effect], sizes=(size,), sizer=sizer
        )
    return drawn


def _rig(case: HiddenCase) -> Rig:
    rig = _base_rig(case.reports_command).at_rate(case.rate)
    drives = tuple(
        drive.model_copy(update={"counts_per_turn": round(2**case.bits / drive.gear)}) for drive in rig.drives
    )
    # Parallel processes need separate buses.
    return rig.model_copy(update={"drives": drives, "bus": CanBus(channel=f"benchmark {os.getpid()}")})


def _base_rig(reports_command: bool) -> Rig:
    rig = simulated_rig()
    voltage = Voltage(kind="command" if reports_command else "motor")
    return rig.model_copy(
        update={"drives": tuple(drive.model_copy(update={"voltage": voltage}) for drive in rig.drives)}
    )


def _machine(robot: RobotName) -> SimConfig:
    return SimConfig() if robot == "default" else load_sim(ROBOTS / f"{robot}.toml")


@cache
def _sizer(robot: RobotName, reports_command: bool) -> EffectSizer:
    return EffectSizer(_base_rig(reports_command), _machine(robot))
