"""Check, set-up and run of a made-up drive, whatever its dictionary says, as a rig file for it would ask."""

import json
import math
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from drivers.canopen.drive import CanopenDrives
from drivers.canopen.requirements import TABLE
from drivers.protocol import Goal, Power, Sample
from drivers.simulated.habits import Habits
from recordings.errors import BadInput, RunFailed
from recordings.rig import Axis, Drive, Limits, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus, reach
from tests.drivers.simulated.dictionaries import (
    GEAR,
    RATED_CURRENT,
    RATED_TORQUE,
    MadeUpDrive,
)

RATED = RATED_TORQUE * GEAR / 1000
"""Rated torque at the joint [N m]."""
ACCELERATION, SPEED = 20.0, 1.0
"""Limit of the quick stop [rad/s^2], speed before it [rad/s]."""
SAFETY = tuple(dict.fromkeys(f"{row.address[0]:04X}" for row in TABLE if row.role == "safety"))


@dataclass
class Outcome:
    """Outcome of one drive: either a stated reason, or what was measured."""

    problems: list[str]
    unproven: list[str]
    """Objects that the check says will be written: only writing them shows whether the drive accepts them."""
    refused: str = ""
    samples: tuple[tuple[Sample, float, float], ...] = ()
    """Samples with the true voltage [V] and torque [N m]."""
    deceleration: float = math.nan
    """Of the quick stop [rad/s^2]."""
    reports: tuple[str, ...] = ()


def missing_from(made_up: MadeUpDrive) -> list[str]:
    """Objects of safety that the dictionary lacks."""
    indices = {index for index, _ in made_up.items}
    return [name for name in SAFETY if int(name, 16) not in indices]


def rig_of(made_up: MadeUpDrive, rate: float = 500.0, **changes: Any) -> Rig:
    """A rig file as an engineer would write it for this drive."""
    items, habits = made_up.items, made_up.habits
    modes = int(str(items[0x6502, 0].default)) if (0x6502, 0) in items else 0
    keys: dict[str, Any] = {
        "node_id": 1,
        "assume_mode": True,
        "mode": "interpolated" if modes & 0xC0 == 0x40 or (0x607A, 0) not in items else "cyclic",
        "accept_missing": missing_from(made_up),
    }
    if not int(str(items[0x60AA, 0].default if (0x60AA, 0) in items else 0)) and (0x608E, 0) not in items:
        keys["units"] = {"acceleration": "counts/s^2"}
    if (0x605A, 0) in items and 6 in habits.get("allowed", {}).get("605A", ()):
        keys["quick_stop_option"] = 6
    if "voltage" in habits:
        mappable = items[0x2030, 0].mappable
        keys["voltage"] = {
            **{"index": 0x2030, "sub": 0, "scale": habits["voltage_scale"]},
            "transfer": "pdo" if mappable else "sdo",
        }
    elif (0x6077, 0) in items:
        keys |= {"torque_source": "torque_actual", "rated_torque": RATED}
    else:
        keys |= {"torque_source": "current_actual", "rated_current": RATED_CURRENT / 1000}
    return Rig(
        name="made up",
        mechanism="axes",
        rate=rate,
        axes=(Axis(),),
        drives=(Drive.model_validate_json(json.dumps(keys | changes)),),
        limits=Limits(acceleration=ACCELERATION, following_error=0.2),
        torque=Torque(gain=(1.0,), per_ampere=(RATED / (RATED_CURRENT / 1000),)),
    )


def bus_of(made_up: MadeUpDrive, rig: Rig) -> LossyBus:
    """A bus with one drive that has this dictionary."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.eds"
        path.write_text(made_up.eds)
        return LossyBus(rig, path, Habits.model_validate_json(json.dumps(dict(made_up.habits))))


def outcome_of(made_up: MadeUpDrive, rig: Rig, see: Callable[[int, bool], object] | None = None) -> Outcome:
    """Check the drive, set it up, move it for half a second, stop it; it never ends with power.

    `see(id, sent)` is called for each frame during the motion.
    """
    bus = bus_of(made_up, rig)
    reports: list[str] = []
    driver = bus.driver(lambda level, source, text: reports.append(text))
    driver.discover()
    findings = driver.check()
    outcome = Outcome(
        [f"{f.what}: {f.found}" for f in findings if f.verdict == "problem"],
        [f.what.split()[0] for f in findings if f.verdict == "will be written"],
    )
    try:
        driver.configure()
        if see is not None:
            driver._link.tap = lambda _, message, sent: see(message.arbitration_id, sent)  # type: ignore[misc]
        _move(driver, bus, rig, outcome)
    except (BadInput, RunFailed) as error:
        outcome.refused = str(error)
    finally:
        driver.goal = Goal.DISABLED
        driver.close()
    assert not bus.enabled
    outcome.reports = tuple(reports)
    return outcome


def _move(driver: CanopenDrives, bus: LossyBus, rig: Rig, outcome: Outcome) -> None:
    reach(driver, Goal.ENABLED, Power.ON)
    generator = bus.drives[0].generator
    start, samples = generator.position, []
    count = round(0.5 * rig.rate)
    for k, setpoint in enumerate(driver.encode((start + SPEED / rig.rate * np.arange(count))[:, None])):
        bus.volts, bus.torque = 8 * math.sin(0.1 * k), 0.8 * RATED * math.sin(0.07 * k)
        sample = driver.exchange(setpoint, 0.01)
        assert sample.trouble is None, sample.trouble
        samples.append((sample, bus.volts, bus.torque))
    outcome.samples = tuple(samples)
    driver.goal = Goal.STOPPED
    for _ in range(round(rig.rate)):
        sample = driver.exchange(None, 0.01)
        if bus.drives[0].powered and generator._deceleration is not None:
            outcome.deceleration = generator._deceleration
        if sample.power == (Power.OFF,):
            return
    raise RunFailed("still powered after a quick stop")
