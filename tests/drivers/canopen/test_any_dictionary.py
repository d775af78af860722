"""Whatever the dictionary of a drive: the check names a problem, the set-up a refused value, or the run is right."""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings

from drivers.canopen import roles
from drivers.canopen.bus import Link
from drivers.canopen.drive import CanopenDrives
from drivers.protocol import Goal, Power, Sample
from drivers.simulated.habits import Habits
from recordings.errors import BadInput, RunFailed
from recordings.rig import Axis, Drive, Limits, Rig, Torque
from tests.drivers.canopen.lossy_bus import LossyBus
from tests.drivers.simulated.dictionaries import (
    GEAR,
    MADE_UP,
    RATED_CURRENT,
    RATED_TORQUE,
    MadeUpDrive,
    made_up_drives,
)

RATED = RATED_TORQUE * GEAR / 1000
"""Rated torque at the joint [N m]."""
ACCELERATION, SPEED = 20.0, 1.0
"""Limit of the quick stop [rad/s^2], speed before it [rad/s]."""
SAFETY = tuple(f"{index:04X}" for index, role in roles.ROLES.items() if role.role == "safety")
REFUSED = r"refuses to write object (605A|6066|6065|6085|60C2|607D)|shows mode"


@dataclass
class Outcome:
    """Outcome of one drive: either a stated reason, or what was measured."""

    problems: list[str]
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
        drives=(Drive.model_validate_json(_json(keys | changes)),),
        limits=Limits(acceleration=ACCELERATION, following_error=0.2),
        torque=Torque(gain=(1.0,), per_ampere=(RATED / (RATED_CURRENT / 1000),)),
    )


def _json(keys: dict[str, Any]) -> str:
    import json

    return json.dumps(keys)


def bus_of(made_up: MadeUpDrive, rig: Rig) -> LossyBus:
    """A bus with one drive that has this dictionary."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.eds"
        path.write_text(made_up.eds)
        return LossyBus(rig, path, Habits.model_validate_json(_json(dict(made_up.habits))))


def outcome_of(made_up: MadeUpDrive, rig: Rig, seen: set[int] | None = None) -> Outcome:
    """Check the drive, set it up, move it for half a second, stop it; it never ends with power.

    `seen` collects the ids of the frames that the drive sends during the motion.
    """
    bus = bus_of(made_up, rig)
    reports: list[str] = []
    link = Link(bus)
    link.clock = bus.now_ns
    driver = CanopenDrives(rig, link, lambda level, source, text: reports.append(text))
    driver.discover()
    outcome = Outcome([f"{f.what}: {f.found}" for f in driver.check() if f.verdict == "problem"])
    try:
        driver.configure()
        if seen is not None:
            link.tap = lambda _, message, sent: None if sent else seen.add(message.arbitration_id)
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
    driver.goal = Goal.ENABLED
    for _ in range(round(0.5 * rig.rate)):
        if driver.exchange(None, 0.01).power == (Power.ON,):
            break
    else:
        raise RunFailed("not enabled")
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


def judge(made_up: MadeUpDrive, rig: Rig, outcome: Outcome) -> None:
    """Assert that the outcome is one of the three that are allowed."""
    if outcome.problems:
        assert outcome.refused, outcome.problems
        assert not outcome.samples
        return
    if outcome.refused:
        assert not outcome.samples, outcome.refused
        assert _may_refuse(made_up, outcome.refused), outcome.refused
        return
    assert len(outcome.samples) == round(0.5 * rig.rate)
    if (0x6085, 0) in made_up.items:
        assert outcome.deceleration == pytest.approx(ACCELERATION, rel=0.05)
    drive = rig.drives[0]
    source, scale = drive.torque_source, drive.voltage.scale if "voltage" in made_up.habits else RATED / 1000
    for sample, volts, torque in outcome.samples:
        measured = sample.voltage[0] if source == "voltage" else (sample.effort or (math.nan,))[0]
        true = volts if source == "voltage" else torque
        if source == "voltage" and drive.voltage.transfer == "sdo":
            continue
        assert measured == pytest.approx(true, abs=1.01 * scale)


def _may_refuse(made_up: MadeUpDrive, text: str) -> bool:
    """Whether a value was refused that the dictionary limits: only writing it tells."""
    limited = {f"{index:04X}" for (index, _), item in made_up.items.items() if item.high is not None}
    limited |= {address[:4] for address in made_up.habits.get("allowed", {})}
    return any(f"object {index}" in text for index in limited)


@settings(max_examples=20, deadline=None, derandomize=True)
@given(made_up_drives())
def test_random_dictionary(made_up: MadeUpDrive) -> None:
    rig = rig_of(made_up)
    judge(made_up, rig, outcome_of(made_up, rig))


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(made_up_drives())
def test_two_hundred_random_dictionaries(made_up: MadeUpDrive) -> None:
    rig = rig_of(made_up)
    judge(made_up, rig, outcome_of(made_up, rig))


@settings(max_examples=20, deadline=None, derandomize=True)
@given(made_up_drives())
def test_missing_safety_is_never_driven_without_acceptance(made_up: MadeUpDrive) -> None:
    rig = rig_of(made_up, accept_missing=[])
    outcome = outcome_of(made_up, rig)
    judge(made_up, rig, outcome)
    for name in missing_from(made_up):
        assert outcome.refused
        assert any(problem.startswith(name) for problem in outcome.problems)


def test_wilful_drive_runs_with_its_own_quick_stop_option_and_what_it_refuses_is_said() -> None:
    made_up = MADE_UP["wilful"]
    rig = rig_of(made_up, accept_missing=["6066"], homed={"index": 0x6041, "mask": 0x8000})
    outcome = outcome_of(made_up, rig)
    judge(made_up, rig, outcome)
    assert outcome.samples
    assert any("1006:00" in text for text in outcome.reports)
    assert any("6066:00" in text and "host stops all drives" in text for text in outcome.reports)


def test_drive_without_an_accepted_object_is_driven_and_the_loss_is_said() -> None:
    items = {address: item for address, item in MADE_UP["wide_voltage"].items.items() if address[0] != 0x605A}
    made_up = MadeUpDrive(items, MADE_UP["wide_voltage"].habits)
    outcome = outcome_of(made_up, rig_of(made_up))
    assert outcome.samples
    (text,) = outcome.reports
    assert text.startswith("driven without 605Ah")
    assert "the host waits for standstill" in text


def test_wilful_drive_without_acceptance_is_refused_by_name() -> None:
    outcome = outcome_of(MADE_UP["wilful"], rig_of(MADE_UP["wilful"]))
    assert 'accept_missing = ["6066"]' in outcome.refused


def test_option_that_the_drive_refuses_names_the_key() -> None:
    rig = rig_of(MADE_UP["wilful"], accept_missing=["6066"], quick_stop_option=2)
    outcome = outcome_of(MADE_UP["wilful"], rig)
    assert "the drive has 6" in outcome.refused
    assert "quick_stop_option" in outcome.refused


def test_voltage_of_32_bits_is_recorded_whole() -> None:
    made_up = MADE_UP["wide_voltage"]
    rig = rig_of(made_up)
    outcome = outcome_of(made_up, rig)
    judge(made_up, rig, outcome)
    assert max(sample.voltage[0] for sample, _, _ in outcome.samples) == pytest.approx(8.0, abs=0.02)


def test_polled_voltage_of_32_bits_is_recorded_whole() -> None:
    made_up = MADE_UP["wide_voltage"]
    keys = {"index": 0x2030, "sub": 0, "scale": 0.0001, "transfer": "sdo"}
    made_up = MadeUpDrive(made_up.items, {**made_up.habits, "voltage_scale": 0.0001})
    outcome = outcome_of(made_up, rig_of(made_up, voltage=keys))
    polled = [(sample.voltage[0], volts) for sample, volts, _ in outcome.samples if not math.isnan(sample.voltage[0])]
    assert len(polled) > 100
    assert all(any(value == pytest.approx(volts, abs=1e-3) for _, volts in polled) for value, _ in polled)
    assert max(value for value, _ in polled) > 7.9  # 79,000 counts


@pytest.mark.parametrize("rate", [500.0, 1000.0])
def test_drive_that_interpolates_over_one_millisecond_runs_at_1000_hz_only(rate: float) -> None:
    made_up = MADE_UP["one_millisecond"]
    rig = rig_of(made_up, rate, counts_per_turn=360_000)
    outcome = outcome_of(made_up, rig)
    assert outcome.problems == []
    if rate == 1000.0:
        judge(made_up, rig, outcome)
        assert outcome.samples
    else:
        assert "60C2:01" in outcome.refused
        assert "1000 Hz" in outcome.refused


def test_drive_without_cyclic_modes_ends_in_that_reason() -> None:
    outcome = outcome_of(MADE_UP["profile_only"], rig_of(MADE_UP["profile_only"]))
    assert "neither mode 7 nor 8" in outcome.refused


def test_slow_drive_in_units_of_an_older_profile() -> None:
    made_up = MADE_UP["slow"]
    rig = rig_of(made_up)
    outcome = outcome_of(made_up, rig)
    judge(made_up, rig, outcome)
    assert outcome.samples


def test_other_pdos_are_off_during_the_run() -> None:
    made_up = MADE_UP["wide_voltage"]
    rig = rig_of(made_up)
    seen: set[int] = set()
    outcome = outcome_of(made_up, rig, seen)
    assert outcome.samples
    assert seen & {0x181, 0x281, 0x381, 0x481} == {0x181, 0x281}  # status and position; voltage


def test_mode_that_is_not_listed_is_tried_only_where_the_rig_file_asks() -> None:
    items = {address: item for address, item in MADE_UP["wide_voltage"].items.items() if address[0] != 0x6502}
    made_up = MadeUpDrive(items, MADE_UP["wide_voltage"].habits)
    assert outcome_of(made_up, rig_of(made_up)).samples
    refused = outcome_of(made_up, rig_of(made_up, assume_mode=False))
    assert "6502h is absent" in refused.problems[0]
    assert "assume_mode" in refused.refused


def test_units_that_contradict_the_drive_are_refused_before_anything_is_written() -> None:
    made_up = MADE_UP["wilful"]
    keys = {"accept_missing": ["6066"], "units": {"acceleration": "counts/s^2"}}
    outcome = outcome_of(made_up, rig_of(made_up, **keys))
    assert any("1 rad/s^2 of the joint" in problem for problem in outcome.problems)
    assert "200.535" in outcome.refused
    assert "27379.7" in outcome.refused
