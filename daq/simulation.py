"""Simulated rig of `daq record` and `daq sim`: its sim file, hidden effects and sealed truth."""

from collections.abc import Sequence
from itertools import cycle
from pathlib import Path
from typing import Any

from daq.hidden_seed import HiddenSeed
from drivers.simulated import transports as simulations
from drivers.simulated.config import EffectSpec, SimConfig, SimDrive, SimEvent, load_sim
from drivers.simulated.effect import build
from drivers.simulated.habits import habits_from
from drivers.simulated.service import Service
from recordings.command_line import say
from recordings.errors import BadInput
from recordings.recording import Pace
from recordings.rig import Rig


def configured(
    rig: Rig,
    sim: Path | None,
    hidden: HiddenSeed | None,
    truth: Path | None,
    eds: Sequence[Path] = (),
    habits: Sequence[str] = (),
) -> SimConfig:
    """Load the machine to simulate from the sim file, or draw its effects by `hidden`.

    `eds`, `habits`: dictionaries (one for all drives or one per joint) and settings KEY=VALUE of all drives; they
    replace those of the sim file.

    Hidden effects are written to the sealed file `truth`; None: nothing is recorded of which a truth could be told.

    Raises:
        BadInput: the sim file is not valid, effects come from both `sim` and `hidden`, or `truth` exists.
    """
    from drivers.simulated.hidden import draw
    from drivers.simulated.seal import seal
    from drivers.simulated.seal import truth as truth_about
    from drivers.simulated.sizing import resolve

    config = with_dictionaries(SimConfig() if sim is None else load_sim(sim), eds, habits)
    if hidden is not None:
        if config.all_effects:
            raise BadInput(
                "either --hidden or a sim file with [[effects]] or [[events]] expected, both found; choose one"
            )
        config = config.model_copy(update=_drawn(draw(hidden.seed, rig, config), hidden.at))
    if not config.all_effects:
        return config
    if truth is not None and truth.exists():
        raise BadInput(f"a new name expected, {truth} exists and no truth is replaced; give another one")
    config = resolve(rig, config)
    if truth is not None:
        seal(truth, truth_about(rig, config, None if hidden is None else hidden.seed))
    return config


def _drawn(effects: Sequence[EffectSpec], at: float | None) -> dict[str, Any]:
    """What a sim file would say of `effects` that are there from the beginning, or begin `at` a time [s]."""
    if at is None:
        return {"effects": effects}
    return {"events": tuple(SimEvent(at=at, effect=build(effect).at(at).spec()) for effect in effects)}


def with_dictionaries(config: SimConfig, eds: Sequence[Path], habits: Sequence[str]) -> SimConfig:
    """`config` with other dictionaries and habits of its drives.

    Raises:
        BadInput: neither one EDS nor one per joint, or a habit is not valid.
    """
    drives = list(config.drives or (SimDrive(),))
    if eds:
        joints = len(config.drive_of_each_joint)
        if len(eds) not in (1, joints):
            raise BadInput(f"--eds: one file for all joints or {joints} expected, {len(eds)} found")
        drives = [
            drive.model_copy(update={"eds": str(path)}) for drive, path in zip(cycle(drives), eds, strict=False)
        ]
    if habits:
        drives = [drive.model_copy(update={"habits": habits_from(habits, drive.habits)}) for drive in drives]
    return config if not (eds or habits) else config.model_copy(update={"drives": tuple(drives)})


def simulated(rig: Rig, config: SimConfig, pace: Pace, seed: int) -> Service:
    """Serve the simulated rig on the bus or the lines of `rig`; the result is a context manager.

    Raises:
        BadInput: the rig is no delta robot, the bus cannot be opened, a dictionary cannot be read, or drives on
            serial lines should have one.
    """
    if len(rig.drives) != len(config.drive_of_each_joint):
        raise BadInput(
            f"the simulated machine is a delta robot with {len(config.drive_of_each_joint)} drives, "
            f"{len(rig.drives)} found in the rig file; connect them, or describe a delta robot"
        )
    if (config.drives or any(event.trouble for event in config.events)) and rig.bus.transport != "canopen":
        raise BadInput(
            "[[drives]], a trouble in [[events]], --eds and --habit are for drives on a CAN bus, serial lines found; "
            "drop them"
        )
    service = simulations.of(rig).serve(rig, config, pace, seed)
    service.warn = lambda text: say(f"warning: {text}", "yellow")
    return service


def torque_age(rate: float) -> float:
    """By how much the torque that simulated drives report is older than the position beside it [s], at a cycle rate
    [Hz]: a position is what the torque of the last step of the plant led to, and both are reported together."""
    from drivers.simulated.machine import plant_step

    return plant_step(rate)
