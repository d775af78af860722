"""Whatever the dictionary of a drive: the check names a problem, the set-up a refused value, or the run is right."""

import math
import tempfile
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings

from recordings.rig import Rig
from tests.drivers.canopen.made_up_runs import (
    ACCELERATION,
    RATED,
    Outcome,
    missing_from,
    outcome_of,
    rig_of,
)
from tests.drivers.simulated.dictionaries import (
    MADE_UP,
    MadeUpDrive,
    made_up_drives,
)


def judge(made_up: MadeUpDrive, rig: Rig, outcome: Outcome) -> None:
    """Assert that the outcome is one of the three that are allowed."""
    if outcome.problems:
        assert outcome.refused, outcome.problems
        assert not outcome.samples
        return
    if outcome.refused:
        assert not outcome.samples, outcome.refused
        assert _may_refuse(made_up, outcome.refused), outcome.refused
        assert any(f"object {address}" in outcome.refused for address in outcome.unproven), outcome.refused
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


def run_and_judge(made_up: MadeUpDrive, rate: float = 500.0, **keys: Any) -> Outcome:
    rig = rig_of(made_up, rate, **keys)
    outcome = outcome_of(made_up, rig)
    judge(made_up, rig, outcome)
    return outcome


FEW = settings(max_examples=20, deadline=None, derandomize=True)
MANY = pytest.param(settings(max_examples=200, deadline=None), marks=pytest.mark.slow)


@pytest.mark.parametrize("examples", [FEW, MANY])
def test_random_dictionary(examples: settings) -> None:
    examples(given(made_up_drives())(run_and_judge_any))()


def run_and_judge_any(made_up: MadeUpDrive) -> None:
    run_and_judge(made_up)


@FEW
@given(made_up_drives())
def test_with_the_file_of_the_drive_the_check_names_every_limit(made_up: MadeUpDrive) -> None:
    made_up = MadeUpDrive(made_up.items, {key: v for key, v in made_up.habits.items() if key != "allowed"})
    with tempfile.TemporaryDirectory() as folder:
        path, _ = made_up.write(Path(folder))
        outcome = outcome_of(made_up, rig_of(made_up, eds=str(path)))
    assert outcome.problems or not outcome.refused, outcome.refused


@FEW
@given(made_up_drives())
def test_missing_safety_is_never_driven_without_acceptance(made_up: MadeUpDrive) -> None:
    outcome = run_and_judge(made_up, accept_missing=[])
    for name in missing_from(made_up):
        assert outcome.refused
        assert any(problem.startswith(name) for problem in outcome.problems)


WIDE, WILFUL = MADE_UP["wide_voltage"], MADE_UP["wilful"]
ACCEPTED: dict[str, Any] = {"accept_missing": ["6066"]}


def test_wilful_drive_runs_with_its_own_quick_stop_option_and_what_it_refuses_is_said() -> None:
    outcome = run_and_judge(WILFUL, homed={"index": 0x6041, "mask": 0x8000}, **ACCEPTED)
    assert outcome.samples
    assert any("1006:00" in text for text in outcome.reports)
    assert any("6066:00" in text and "host stops all drives" in text for text in outcome.reports)


@pytest.mark.parametrize(
    ("name", "keys", "reasons"),
    [
        ("wilful", {}, ['accept_missing = ["6066"]']),
        ("wilful", {**ACCEPTED, "quick_stop_option": 2}, ["the drive has 6", "quick_stop_option"]),
        # Before anything is written.
        (
            "wilful",
            {**ACCEPTED, "units": {"acceleration": "counts/s^2"}},
            ["1 rad/s^2 of the joint", "200.535", "27379.7"],
        ),
        ("profile_only", {}, ["neither mode 7 nor 8"]),
        ("one_millisecond", {"counts_per_turn": 360_000}, ["60C2:01", "1000 Hz"]),
    ],
)
def test_drive_is_refused_with_the_object_and_the_key_to_change(
    name: str, keys: dict[str, Any], reasons: list[str]
) -> None:
    outcome = run_and_judge(MADE_UP[name], **keys)
    assert all(reason in outcome.refused for reason in reasons), outcome.refused


def test_drive_without_an_accepted_object_is_driven_and_the_loss_is_said() -> None:
    items = {address: item for address, item in WIDE.items.items() if address[0] != 0x605A}
    outcome = run_and_judge(MadeUpDrive(items, WIDE.habits))
    assert outcome.samples
    (text,) = outcome.reports
    assert text.startswith("driven without 605A:00")
    assert "the host waits for standstill" in text


def test_voltage_of_32_bits_is_recorded_whole_in_a_pdo_and_polled() -> None:
    outcome = run_and_judge(WIDE)
    assert max(sample.voltage[0] for sample, _, _ in outcome.samples) == pytest.approx(8.0, abs=0.02)
    keys = {"index": 0x2030, "sub": 0, "scale": 0.0001, "transfer": "sdo"}
    fine = MadeUpDrive(WIDE.items, {**WIDE.habits, "voltage_scale": 0.0001})
    polled = [(s.voltage[0], volts) for s, volts, _ in run_and_judge(fine, voltage=keys).samples]
    polled = [(value, volts) for value, volts in polled if not math.isnan(value)]
    assert len(polled) > 100
    assert all(any(value == pytest.approx(volts, abs=1e-3) for _, volts in polled) for value, _ in polled)
    assert max(value for value, _ in polled) > 7.9  # 79,000 counts


def with_entries(made_up: MadeUpDrive, entries: dict[int, int]) -> MadeUpDrive:
    """The drive with so many entries in the mapping of each PDO, by the index of the mapping object."""
    items = {
        address: item
        for address, item in made_up.items.items()
        if address[1] <= entries.get(address[0], 8) or not 0x1600 <= address[0] < 0x1C00
    }
    return MadeUpDrive(items, made_up.habits)


@pytest.mark.parametrize(
    ("entries", "sent", "received"),
    [
        ({}, {0x201}, {0x181, 0x281}),  # the drive's other PDOs are off
        ({0x1600: 1, 0x1A00: 1}, {0x301}, {0x181, 0x281}),  # one object in the first PDO, more in the second
        ({0x1600: 1, 0x1601: 1, 0x1A00: 1, 0x1A01: 1, 0x1A02: 1, 0x1A03: 1}, {0x201, 0x301}, {0x181, 0x281, 0x381}),
    ],
)
def test_pdos_of_a_drive_that_maps_few_objects(entries: dict[int, int], sent: set[int], received: set[int]) -> None:
    made_up = with_entries(WIDE, entries)
    rig = rig_of(made_up)
    frames: dict[bool, set[int]] = {True: set(), False: set()}
    outcome = outcome_of(made_up, rig, lambda arbitration_id, is_sent: frames[is_sent].add(arbitration_id))
    judge(made_up, rig, outcome)
    assert outcome.samples
    assert frames[True] & set(range(0x201, 0x600, 0x100)) == sent
    assert frames[False] & set(range(0x181, 0x580, 0x100)) == received
