"""Where a held-out motion goes beyond the training, and the model fails there, that is said."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.extrapolation import extrapolation_warnings
from recordings.rig import simulated_rig

_ROWS = 2000
_TIME = np.arange(_ROWS) / 500.0


def _said(
    reach: float, failing_where: Any, other_motion: bool = True, still: int | None = None, floor: float = 1.0
) -> list[str]:
    """Of a held-out motion with `reach` times the torque of joint 2 of the training, and errors of 5 floors there."""
    recording = SimpleNamespace(rig=simulated_rig())
    wave = np.stack([np.sin(2 * np.pi * (0.5 + 0.1 * joint) * _TIME) for joint in range(3)], axis=1)
    motions = [wave, wave * [1.0, reach, 1.0]]
    motion = [
        SimpleNamespace(velocity=np.roll(one, 100, axis=0), position=np.roll(wave, 50, axis=0)) for one in motions
    ]
    datasets = tuple(
        SimpleNamespace(recording=recording, torque=one, motion=moved, time=_TIME, rate=500.0, bandwidth=50.0)
        for one, moved in zip(motions, motion, strict=True)
    )
    rows = np.ones((_ROWS, 3), bool)
    seen = rows.copy()
    if still is not None:
        seen[:, still] = False
    residual = np.random.default_rng(0).normal(size=(_ROWS, 3))
    failed = residual.copy()
    failed[failing_where(motions[1][:, 1]), 1] *= 5.0
    material: Any = SimpleNamespace(
        datasets=datasets, other_motion=other_motion, seen=(seen, ~rows), held=(~rows, rows), fitting=(0,)
    )
    state: Any = SimpleNamespace(residuals=(residual, failed))
    line: Any = SimpleNamespace(rms=np.full(3, floor))
    return list(extrapolation_warnings(material, state, line))


def test_what_fails_only_beyond_the_training_is_blamed_on_that() -> None:
    (said,) = _said(1.5, lambda torque: np.abs(torque) > 1.05)
    assert said.startswith("Joint 2: ")
    assert "the torque of joint 2 is outside of the -1 to 1 N m that the fit has seen" in said


@pytest.mark.parametrize(
    ("reach", "where"),
    [
        (1.5, lambda torque: np.abs(torque) < 0.5),  # it fails within what was seen
        (1.5, lambda torque: torque > 9.0),  # it does not fail
        (1.0, lambda torque: torque > 0.8),  # nothing is beyond
        (20.0, lambda torque: torque < 9.0),  # nearly all is beyond
        (1.5, lambda torque: (torque > 1.05) & (_TIME < 0.75)),  # an event, which happens to be there
    ],
)
def test_what_fails_elsewhere_is_not(reach: float, where: Any) -> None:
    assert _said(reach, where) == []


def test_nothing_is_beyond_where_parts_of_the_same_motion_are_held_out() -> None:
    assert _said(1.5, lambda torque: np.abs(torque) > 1.05, other_motion=False) == []


def test_a_joint_that_fits_saw_nothing_of_has_no_range() -> None:
    assert _said(1.5, lambda torque: np.abs(torque) > 1.05, still=1) == []


def test_a_floor_of_nothing_is_no_obstacle() -> None:
    assert _said(1.5, lambda torque: torque > 9.0, floor=0.0) == []
