"""Whatever the dictionary of a drive: the check names a problem, the set-up a refused value, or the run is right."""

import math
import tempfile
from pathlib import Path

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

REFUSED = r"refuses to write object (605A|6066|6065|6085|60C2|607D)|shows mode"


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
def test_with_the_file_of_the_drive_the_check_names_every_limit(made_up: MadeUpDrive) -> None:
    made_up = MadeUpDrive(made_up.items, {key: v for key, v in made_up.habits.items() if key != "allowed"})
    with tempfile.TemporaryDirectory() as folder:
        path, _ = made_up.write(Path(folder))
        outcome = outcome_of(made_up, rig_of(made_up, eds=str(path)))
    assert outcome.problems or not outcome.refused, outcome.refused


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
    outcome = outcome_of(made_up, rig, lambda arbitration_id, sent: sent or seen.add(arbitration_id))
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
        ({0x1600: 1, 0x1A00: 1}, {0x301}, {0x181, 0x281}),  # one object in the first PDO, more in the second
        ({0x1600: 1, 0x1601: 1, 0x1A00: 1, 0x1A01: 1, 0x1A02: 1, 0x1A03: 1}, {0x201, 0x301}, {0x181, 0x281, 0x381}),
    ],
)
def test_drive_that_maps_one_object_into_a_pdo(entries: dict[int, int], sent: set[int], received: set[int]) -> None:
    made_up = with_entries(MADE_UP["wide_voltage"], entries)
    rig = rig_of(made_up)
    frames: dict[bool, set[int]] = {True: set(), False: set()}
    outcome = outcome_of(made_up, rig, lambda arbitration_id, is_sent: frames[is_sent].add(arbitration_id))
    judge(made_up, rig, outcome)
    assert outcome.samples
    assert frames[True] & set(range(0x201, 0x600, 0x100)) == sent
    assert frames[False] & set(range(0x181, 0x580, 0x100)) == received
