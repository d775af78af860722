"""Warnings of a diagnosis about its recordings and its parameters."""

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.diagnosis.document.document import ParameterValue
from ident.diagnosis.document.warnings import bound_warnings, data_warnings, other_machine
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import SplitData
from recordings.recording import Bools, Floats, Recording
from tests.ident import building

GOOD = building.record(noise=0.05)
UNFINISHED = replace(GOOD, run=GOOD.run.model_copy(update={"exit_status": None}))


def warnings(split: SplitData, *effects: str, **changes: Any) -> str:
    model = FittedModel(replace(split, **changes), building.fitted(split, *effects).solution)
    unexplained = SimpleNamespace(significant=False)
    diagnosis: Any = SimpleNamespace(
        split=model.split, model=model, library={}, unexplained=unexplained, without_weight=False
    )
    return " ".join(data_warnings(diagnosis))


def averaged(recording: Recording) -> Recording:
    """The `recording` of a drive that reports the mean of two samples."""
    assert recording.effort is not None
    mean = (recording.effort[1:] + recording.effort[:-1]) / 2
    return replace(recording, effort=np.concatenate([recording.effort[:1], mean]))


def of_voltage(recording: Recording) -> Recording:
    assert recording.effort is not None
    return replace(recording, voltage=np.sign(recording.effort) * np.sqrt(np.abs(recording.effort)), effort=None)


@pytest.mark.parametrize(
    ("recording", "changes", "expected"),
    [
        (GOOD, {"standstill_share": 0.08}, "8% of the rows are left out"),
        (GOOD, {"unjudged_shares": (0.0, 0.44, 0.113)}, "44.0% (joint 2) and 11.3% (joint 3) are not scored"),
        (of_voltage(GOOD), {}, "The torque gain is assumed, within ± 20 %: it"),
        (UNFINISHED, {}, "Truncated: bench.mcap"),
    ],
)
def test_what_limits_a_recording_is_reported(recording: Recording, changes: dict[str, Any], expected: str) -> None:
    assert expected in warnings(building.split([recording]), **changes)
    assert warnings(building.split([GOOD]), standstill_share=0.0) == ""


@pytest.mark.parametrize(
    ("cycles", "change", "falls"),
    [(1, averaged, True), (1, lambda recording: recording, False), (2, averaged, False)],
)
def test_noise_that_is_not_white_is_told_where_the_floor_needs_it(
    cycles: int, change: Callable[[Recording], Recording], falls: bool
) -> None:
    text = warnings(building.split([change(building.record(cycles=cycles, noise=0.05))]))
    assert ("The noise of joint 1 falls off" in text) is falls


@pytest.mark.parametrize("purpose", ["training", "held-out"])
def test_files_that_disagree_are_named(purpose: str) -> None:
    noisy = building.record(noise=0.2, name="noisy", shape=1)
    files = [GOOD, noisy], [building.record(noise=0.05, name="other", shape=2)]
    text = warnings(building.split(*(files if purpose == "training" else files[::-1])))
    assert f"The {purpose} recordings disagree" in text
    assert "bench.mcap: 1, noisy.mcap: 4" in text


def test_effects_that_the_motion_hardly_distinguishes_are_known_only_together() -> None:
    small, large = (
        building.record(noise=0.05, extra=lambda motion: motion.position, size=size) for size in (0.1, 1.5)
    )
    text = warnings(building.split([small]), "joint_spring", "arm_com_offset")
    assert "joint_spring.k1 and arm_com_offset.a1 are known only together" in text
    assert "known only together" not in warnings(building.split([large]), "joint_spring", "quadratic_friction")


def test_parameter_that_an_effect_imitates_is_known_only_together_with_it() -> None:
    text = warnings(building.split([building.record(noise=0.05)]), "thermal_drift")
    assert "c_v1 and thermal_drift.a1 are known only together" in text
    assert "so what one has too much, the other lacks" in text


@pytest.mark.parametrize(("inertia", "asked"), [(0.0, False), (0.3, True)])
def test_another_machine_that_is_held_out_is_asked_about(inertia: float, asked: bool) -> None:
    other = building.record(noise=0.05, shape=1, name="other", extra=lambda motion: inertia * motion.acceleration)
    sentence = other_machine(building.fitted(building.split([GOOD], [other]))) or ""
    assert sentence.endswith("another robot, payload or rig file?") is asked
    assert other_machine(building.fitted(building.split([GOOD]))) is None


def test_few_rows_for_many_parameters_are_too_short() -> None:
    short = building.split([building.record(cycles=1, noise=0.05)])
    assert "Too short" in warnings(short, "position_dependent_friction")


@pytest.mark.parametrize(
    ("reach", "fails", "warned"),
    [
        (1.5, lambda travel: travel > 1.05, True),
        (1.5, lambda travel: travel < 0.5, False),  # fails inside of the range
        (1.5, lambda travel: travel > 9.0, False),  # does not fail
        (1.5, lambda travel: travel >= 0.0, False),  # fails everywhere
        (1.0, lambda travel: travel > 0.8, False),  # nothing is outside
    ],
)
def test_model_that_fails_only_outside_of_the_training_range_is_excused(
    reach: float, fails: Callable[[Floats], Bools], warned: bool
) -> None:
    """An error of joint 2 by its travel, relative to that of the training motion."""
    farthest = np.abs(building.motion_of(2).position).max(axis=0)

    def missing(motion: building.Motion) -> Floats:
        return fails(np.abs(motion.position) / farthest) * np.array([0.0, 1.0])

    train = building.record(2, noise=0.05)
    other = building.record(2, noise=0.05, seed=1, extra=missing, size=reach, name="other")
    text = warnings(building.split([train], [other]))
    assert ("Joint 2: " in text) == ("Effects that occur only there cannot be identified" in text) == warned
    assert ("where its position is outside" in text) == warned
    assert "Joint 1: " not in text
    assert "only there" not in warnings(building.split([other]))


@pytest.mark.parametrize(
    ("value", "interval", "expected"),
    [
        (-1.0, (-2.0, -0.5), "Impossible: a = -1 (-2 to -0.5) m is below 0"),
        (-1.0, (-2.0, 0.5), "Impossible, though perhaps by chance: a = -1 (-2 to 0.5) m is below 0"),
        (-1.0, None, "Impossible, though perhaps by chance: a = -1 m is below 0"),
        (12.0, (11.0, 13.0), "Impossible: a = 12 (11 to 13) m is above 10"),
        (12.0, (9.0, 15.0), "Impossible, though perhaps by chance: a = 12 (9 to 15) m is above 10"),
        (5.0, (4.0, 6.0), "Unusual: a = 5 (4 to 6) m is at least 5"),
        (1.0, None, "Unusual: a = 1 m is at most 1"),
        (3.0, (-1.0, 12.0), ""),
    ],
)
def test_parameter_outside_of_its_bounds_is_named_with_value_and_interval(
    value: float, interval: tuple[float, float] | None, expected: str
) -> None:
    """The physical bounds are 0 and 10; usual is between 1 and 5. Nothing limits the other parameter."""
    limited, free = (
        ParameterValue(value=value, unit="m", ci95=interval, meaning="", lower=lower, upper=upper)
        for lower, upper in ((0.0, 10.0), (None, None))
    )
    text = " ".join(bound_warnings({"a": limited, "b": free}, {"a": (1.0, 5.0)}))
    assert text.split(". ")[0] == expected


@given(
    value=st.floats(-1e3, 1e3),
    bounds=st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)).map(sorted),
    half=st.floats(0, 1e3),
)
def test_no_parameter_is_outside_of_its_bounds_without_a_caution(
    value: float, bounds: list[float], half: float
) -> None:
    lower, upper = bounds
    interval = (value - half, value + half)
    parameter = ParameterValue(value=value, unit="m", ci95=interval, meaning="", lower=lower, upper=upper)
    text = " ".join(bound_warnings({"a": parameter}, {}))
    assert ("Impossible" in text) == (not lower <= value <= upper)
