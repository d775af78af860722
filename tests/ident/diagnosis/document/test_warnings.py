"""Warnings of a diagnosis about its recordings."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.document.warnings import data_warnings
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import SplitData
from recordings.recording import Recording
from tests.ident import building

GOOD = building.record(noise=0.05)


def warnings(split: SplitData, *effects: str, **changes: Any) -> str:
    fitted = building.fitted(split, *effects)
    model = FittedModel(replace(split, **changes), fitted.solution)
    unexplained = SimpleNamespace(significant=False)
    diagnosis: Any = SimpleNamespace(split=model.split, model=model, library={}, unexplained=unexplained)
    return " ".join(data_warnings(diagnosis))


def of_voltage(recording: Recording) -> Recording:
    assert recording.effort is not None
    return replace(recording, voltage=np.sign(recording.effort) * np.sqrt(np.abs(recording.effort)), effort=None)


def test_good_recordings_have_no_warnings() -> None:
    assert warnings(building.split([GOOD]), standstill_share=0.0) == ""


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"standstill_share": 0.08}, "8% of the rows are left out"),
        ({"unjudged_shares": (0.0, 0.44, 0.113)}, "44.0% (joint 2) and 11.3% (joint 3) are not scored"),
    ],
)
def test_excluded_rows_are_reported(changes: dict[str, Any], expected: str) -> None:
    assert expected in warnings(building.split([GOOD]), **changes)


@pytest.mark.parametrize(
    ("recording", "expected"),
    [
        (of_voltage(GOOD), "The torque gain is assumed, with an uncertainty of"),
        (replace(GOOD, run=GOOD.run.model_copy(update={"exit_status": None})), "Truncated: bench.mcap"),
    ],
)
def test_short_recordings_and_assumed_gain_are_reported(recording: Recording, expected: str) -> None:
    assert expected in warnings(building.split([recording]))


@pytest.mark.parametrize("purpose", ["training", "held-out"])
def test_files_that_disagree_are_named(purpose: str) -> None:
    noisy = building.record(noise=0.2, name="noisy", shape=1)
    files = [GOOD, noisy], [building.record(noise=0.05, name="other", shape=2)]
    split = building.split(*(files if purpose == "training" else files[::-1]))
    text = warnings(split)
    assert f"The {purpose} recordings disagree" in text
    assert "bench.mcap: 1, noisy.mcap: 4" in text


def test_effects_that_the_motion_hardly_distinguishes_are_known_only_together() -> None:
    small, large = (
        building.record(noise=0.05, extra=lambda motion: motion.position, size=size) for size in (0.1, 1.5)
    )
    text = warnings(building.split([small]), "joint_spring", "arm_com_offset")
    assert "joint_spring.k1 and arm_com_offset.a1 are known only together" in text
    assert "known only together" not in warnings(building.split([large]), "joint_spring", "quadratic_friction")


def test_few_rows_for_many_parameters_are_too_short() -> None:
    short = building.split([building.record(cycles=1, noise=0.05)])
    assert "Too short" in warnings(short, "position_dependent_friction")
