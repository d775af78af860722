"""When a load is picked up and put down is read off the residual."""

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.library import load
from ident.dynamics.effects.library.payload_change import columns
from recordings.recording import Floats, Recording

QUICK = 1e-3
"""A load that is there at once [s]."""


@pytest.fixture(scope="module")
def view(make: object, truth: Floats) -> EffectInputs:
    recording: Recording = make(cycles=4, rate=250.0)  # type: ignore[operator]
    course = prepare(recording, "parallel", 30.0)
    return course.as_recorded.effect_inputs(course, truth)


@pytest.mark.parametrize(("start", "stop"), [(3.3, None), (3.3, 5.9)])
def test_the_instants_are_found(view: EffectInputs, start: float, stop: float | None) -> None:
    suggest = load("payload_change").suggest
    assert suggest
    noise = np.random.default_rng(1).normal(0.0, 0.05, view.motion.position.shape)
    residual = 0.2 * columns(view, {"t_c": start, "t_e": stop or 1e9, "t_r": QUICK})[:, :, 0] + noise
    found = [(one["t_c"], one["t_e"]) for one in suggest(view, residual)]
    expected = pytest.approx((start, stop or 1e9), abs=0.05)
    assert any(one == expected for one in found)


def test_a_load_from_the_beginning_is_one_that_comes_off_for_good(view: EffectInputs) -> None:
    """Lighter from an instant on, and heavier until then, are the same: it is said in one way."""
    suggest = load("payload_change").suggest
    assert suggest
    residual = 0.2 * columns(view, {"t_c": -1.0, "t_e": 4.0, "t_r": QUICK})[:, :, 0]
    (only,) = suggest(view, residual)
    assert only["t_c"] == pytest.approx(4.0, abs=0.05)


def test_the_instant_may_lie_between_two_samples(view: EffectInputs) -> None:
    early, late = (columns(view, {"t_c": start, "t_e": 1e9, "t_r": QUICK}) for start in (3.3, 3.303))
    missing = np.nansum(early - late, axis=0) / view.rate
    at = np.nanargmin(np.abs(view.time - 3.3))
    assert missing == pytest.approx(0.003 * early[at + 2], rel=0.05)


def test_on_a_coarse_grid_the_instants_that_are_read_off_are_neither_late_nor_early(view: EffectInputs) -> None:
    suggest = load("payload_change").suggest
    assert suggest
    coarse = view.decimated(8)
    late = []
    for start in np.linspace(3.0, 3.5, 21):
        residual = columns(view, {"t_c": float(start), "t_e": 1e9, "t_r": QUICK})[::8, :, 0]
        late.append(suggest(coarse, residual)[0]["t_c"] - start)
    assert abs(np.mean(late)) < 0.2 * 8 / view.rate


def test_a_gripper_takes_its_time(view: EffectInputs) -> None:
    there = (
        columns(view, {"t_c": 3.3, "t_e": 1e9, "t_r": 0.2})[:, :, 0]
        / columns(view, {"t_c": 0.0, "t_e": 1e9, "t_r": QUICK})[:, :, 0]
    )
    share = np.interp([3.19, 3.25, 3.3, 3.35, 3.41], view.time, there[:, 0])
    assert share == pytest.approx([0.0, 0.25, 0.5, 0.75, 1.0], abs=0.01)
