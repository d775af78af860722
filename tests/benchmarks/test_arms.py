"""The cases of the benchmark of arms."""

import numpy as np
import pytest

from benchmarks.arms import SIZE, Case

pytest.importorskip("pinocchio")


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["stribeck", "encoder_eccentricity"])
def test_an_effect_has_its_size_on_its_joints_alone(effect: str) -> None:
    case = Case(effect, 0)
    assert case.hidden is not None
    assert case.size(getattr(case.hidden, case.hidden.strength())) == pytest.approx(SIZE, rel=0.05)
    bare, hidden = (case.reports(each)[0] for each in (None, case.hidden))
    changed = np.flatnonzero((np.concatenate(bare) != np.concatenate(hidden)).any(axis=0))
    assert tuple(changed) == case.joints


@pytest.mark.slow
def test_the_torque_of_mujoco_is_that_of_the_base_model() -> None:
    case = Case("nothing", 0)
    (_, torque), *_ = case.reports(None)
    assert np.abs(case.bare[0]).max() < 0.02 * np.sqrt(np.mean(case.filtered(torque) ** 2, axis=0)).max()
