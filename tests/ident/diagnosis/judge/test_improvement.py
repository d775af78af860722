"""The improvement of one model over another, the coverage of its interval, and the rows that judge."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import fftconvolve

from ident.basics import filters
from ident.diagnosis.judge.improvement import BLOCK_SECONDS, MIN_SHARE, MIN_T, Blocks, Improvement
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

RATE = 125.0
TAPS = filters.low_pass(30.0, RATE)[:, None]


def compare(
    before: Floats,
    after: Floats,
    floor: Floats | float = 1.0,
    time: Floats | None = None,
    compared: int = 1,
    smoothed: float = 0.0,
) -> Improvement:
    """Improvement on all rows of one recording; residuals (m, dof), noise floor (dof,).

    smoothed: mean square of the noise that the second model takes.
    """
    time = np.arange(len(before)) / RATE if time is None else time
    split: Any = SimpleNamespace(recordings=[SimpleNamespace(time=time)])
    floors = np.broadcast_to(floor, before.shape[1])
    rows = [np.ones(before.shape, bool)]
    return Blocks.of(split, [before], [after], floors, rows, (0.0, smoothed)).improvement(compared)


def low_passed(rng: np.random.Generator, shape: tuple[int, int]) -> Floats:
    """Noise (m, dof) of variance one behind the low-pass of the preprocessing."""
    white = rng.normal(size=(shape[0] + len(TAPS) - 1, shape[1]))
    return np.asarray(fftconvolve(white, TAPS, "valid", axes=0) / np.linalg.norm(TAPS))


def coverage(seconds: float, before: float, after: float, draws: int, joints: int = 1) -> float:
    """Share of the intervals that contain the true share of the excess that is removed.

    before, after: amplitude of a sine in the residual of each model, beside noise of one noise floor.
    """
    rng = np.random.default_rng(0)
    time = np.arange(round(seconds * RATE)) / RATE
    sine = np.sin(2 * np.pi * 1.3 * time)[:, None]
    true = 1 - after**2 / before**2
    inside = 0
    for _ in range(draws):
        noise = low_passed(rng, (len(time), joints))
        low, high = compare(noise + before * sine, noise + after * sine).interval
        inside += low <= true <= high
    return inside / draws


@pytest.mark.parametrize(("sine", "supported"), [(0.3, False), (3.0, True)])
def test_noise_that_a_model_smooths_is_no_improvement(sine: float, supported: bool) -> None:
    """An elastic joint takes a part of what the encoders' steps make of the torque."""
    noise = low_passed(np.random.default_rng(0), (2500, 1))
    missing = sine * np.sin(2 * np.pi * 1.3 * np.arange(len(noise)) / RATE)[:, None]
    before, after = noise + missing, 0.6 * noise + 0.5 * missing
    assert compare(before, after).is_supported
    assert compare(before, after, smoothed=1 - 0.6**2).is_supported == supported


def test_ratio_is_significant_where_one_block_outweighs_the_others() -> None:
    rng = np.random.default_rng(0)
    size = np.repeat([1.0, 1.0, 1.0, 1.0, 1.0, 30.0], 31)[:, None]
    before = size * rng.normal(size=(186, 1))
    after = 0.2 * before * rng.uniform(0.5, 1.5, before.shape)
    assert compare(before, after).is_supported
    everywhere_else_worse = np.where(size > 1, after, 1.1 * before)
    assert not compare(before, everywhere_else_worse).is_supported


@pytest.mark.parametrize(("blocks", "supported"), [(0, False), (1, False), (2, False), (6, True)])
def test_change_in_few_blocks_suffices_where_it_agrees_with_the_residual(blocks: int, supported: bool) -> None:
    """Blocks of eighty: hardly any tell nothing."""
    noise, change = np.random.default_rng(0).normal(size=(2, 80 * 31, 1))
    block = np.arange(len(noise)) // 31
    change *= 2 * ((block % 14 == 3) & (block < 14 * blocks))[:, None]
    assert compare(noise + change, noise).is_supported is supported
    assert (compare(noise, noise - change).t < -MIN_T) is supported


def test_change_that_gains_nothing_is_as_rarely_supported_as_stated() -> None:
    """Blocks of very different change, of which half agrees with the residual: as much is gained as is lost."""
    rng = np.random.default_rng(0)
    size = np.repeat(rng.lognormal(0.0, 1.0, 60), 31)[:, None]
    values = []
    for _ in range(1000):
        change = size * low_passed(rng, (len(size), 1))
        before = change / 2 + low_passed(rng, (len(size), 1)) * (1 + size / 2)
        values.append(compare(before, before - change).t)
    assert abs(np.mean(values)) < 0.15
    assert np.mean(np.array(values) > 1.645) < 2 * 0.05  # the larger of two tests


CASES = [(7.0, 1.0, 0.5), (7.0, 3.0, 1.0), (10.0, 1.0, 0.9), (20.0, 1.0, 0.1)]
"""Duration of the test rows [s], size of the residual before and after."""


def test_interval_covers_the_true_share() -> None:
    """Four cases, 500 draws each: the binomial error of the mean coverage is 0.5 %."""
    shares = [coverage(*case, draws=500) for case in CASES]
    assert 0.93 <= np.mean(shares) <= 0.97, shares


@pytest.mark.slow
@pytest.mark.parametrize("case", [*CASES, (60.0, 3.0, 1.0)])
@pytest.mark.parametrize("joints", [1, 3])
def test_interval_covers_the_true_share_in_every_case(case: tuple[float, float, float], joints: int) -> None:
    """With 1000 draws the binomial error is 0.7 %."""
    assert 0.93 <= coverage(*case, draws=1000, joints=joints) <= 0.97


def test_interval_of_the_best_of_many_allows_for_the_choice() -> None:
    """Twelve models that change nothing but noise: the best of them looks better, as it was chosen for that."""
    rng, models = np.random.default_rng(0), 12
    inside = {1: 0, models: 0}
    for _ in range(150):
        before = 2 * low_passed(rng, (1000, 1))
        chosen = min(
            (before + 0.3 * low_passed(rng, (1000, 1)) - 0.045 * before for _ in range(models)),
            key=lambda after: float((after**2).sum()),
        )
        true = 1 - (0.955**2 * 4 + 0.09 - 1) / 3
        for compared in inside:
            improvement = compare(before, chosen, compared=compared)
            inside[compared] += improvement.interval[0] <= true <= improvement.interval[1]
    assert inside[1] < 0.8 * 150
    assert inside[models] > 0.93 * 150


def test_rows_where_one_model_is_undefined_are_not_compared() -> None:
    rng = np.random.default_rng(0)
    before = rng.normal(0.0, 2.0, (400, 1))
    after = before / 2
    after[:30] = np.nan
    improvement = compare(before, after)
    assert improvement == compare(np.where(np.isfinite(after), before, np.nan), after)
    assert improvement.reduction == pytest.approx(3.0, rel=0.2)


@given(seed=st.integers(0, 2**32 - 1), unit=st.floats(1e-6, 1e6), kept=st.floats(0.0, 0.99))
def test_unit_of_the_torque_does_not_matter(seed: int, unit: float, kept: float) -> None:
    before = 2 * np.random.default_rng(seed).normal(size=(500, 2))
    expected, result = compare(before, kept * before), compare(unit * before, kept * unit * before, floor=unit)
    assert result.share == pytest.approx(expected.share)
    assert result.interval == pytest.approx(expected.interval)
    assert min(result.t, 20.0) == pytest.approx(min(expected.t, 20.0), rel=0.01)  # rounding makes any larger one


@given(seed=st.integers(0, 2**32 - 1), kept=st.floats(-2.0, 2.0))
def test_share_lies_in_the_interval_and_both_between_minus_one_and_one(seed: int, kept: float) -> None:
    rng = np.random.default_rng(seed)
    before = rng.normal(0.0, rng.uniform(0.1, 3), (300, 1))
    result = compare(before, kept * before)
    assert -1 <= result.interval[0] <= result.share <= result.interval[1] <= 1


def test_all_of_the_excess_is_a_share_of_one() -> None:
    """Every second row of the better model is at the noise floor, the other one as well."""
    before, after = np.full((1000, 1), 3.0), np.ones((1000, 1))
    result = compare(before, after)
    assert (result.share, result.interval) == (1.0, (1.0, 1.0))
    assert (result.reduction, result.remaining) == (8.0, 0.0)


def test_same_model_is_no_improvement_and_a_worse_one_is_negative() -> None:
    residual = np.random.default_rng(0).normal(0.0, 2.0, (1000, 1))
    for same in (residual, residual * (1 - 2**-53)):  # rounding errors are no improvement
        result = compare(residual, same)
        assert (result.share, result.t, result.reduction) == (0.0, 0.0, 0.0)
        assert result.interval == pytest.approx((0.0, 0.0))
    worse = compare(residual, 1.2 * residual)
    assert worse.share < worse.interval[1] < 0
    assert worse.t < -3


def test_share_of_an_excess_that_may_be_chance_is_not_known() -> None:
    noise = np.random.default_rng(0).normal(size=(2000, 1))
    assert compare(noise, 0.999 * noise).interval == (-1.0, 1.0)
    below = compare(0.5 * noise, 0.4 * noise)
    assert (below.share, below.interval) == (0.0, (-1.0, 1.0))
    two = int(2 * BLOCK_SECONDS * RATE)  # as many blocks tell nothing
    assert compare(np.full((two, 1), 3.0), np.ones((two, 1))) == Improvement(0.0, (0.0, 0.0), 0.0, 0.0, 0.0)


def test_joints_count_by_their_own_excess() -> None:
    """What a joint with a tenth of the noise, or without any, leaves makes no other joint negligible."""
    first = np.random.default_rng(1).normal(0.0, 3.0, (1000, 1))
    before, after = np.hstack([first, 2 * first]), np.hstack([first / 3, first])
    for floor in (np.array([1.0, 0.01]), np.array([1.0, 0.0])):
        assert compare(before, after, floor).share == pytest.approx(0.87, abs=0.03)


def test_joints_on_which_two_models_agree_are_not_compared() -> None:
    first = np.random.default_rng(1).normal(0.0, 3.0, (1000, 1))
    alone = compare(first, first / 3)
    for rest in (first, 1.01 * first):
        assert compare(np.hstack([first, 9 * first]), np.hstack([first / 3, 9 * rest])).share == alone.share


def test_blocks_are_of_time_and_not_of_rows() -> None:
    """A gap of time between rows makes no difference to the number of blocks but that of the rows present."""
    rng = np.random.default_rng(2)
    before = rng.normal(0.0, 2.0, (1000, 1))
    time = np.arange(1000) / RATE
    later = np.where(time >= 4.0, time + 1000 * BLOCK_SECONDS, time)
    assert compare(before, before / 2, time=later) == compare(before, before / 2, time=time)


@pytest.mark.parametrize(("taken", "small"), [(MIN_SHARE - 0.01, True), (MIN_SHARE + 0.01, False)])
def test_what_is_negligible_is_measured_by_what_is_missing(taken: float, small: bool) -> None:
    assert Improvement(0.0, (0.0, 0.0), 0.0, taken, 1 - taken).is_small is small
    assert Improvement(0.0, (0.0, 0.0), 9.0, 0.1, -0.2).is_small  # nothing is left above the floor


def test_rows_outside_of_the_travel_of_a_curve_are_not_compared() -> None:
    recordings = [building.record(noise=0.05, seed=i, shape=3, size=1 + i, name=f"motion {i}") for i in range(2)]
    data = building.split(recordings[:1], recordings[1:])
    base, curve = (building.fitted(data, *names) for names in ((), ("position_dependent_friction",)))
    floor = curve.noise_floor.rms
    assert data.judged(base.solution, floor) is data
    train, held_out = data.unjudged(curve.solution, floor)
    assert not (train & data.train[0]).any()
    assert (held_out & data.test[1]).any()
    known = data.judged(curve.solution, floor)
    assert curve.improvement_over(base) == curve.improvement_over(base, known.test)
    inside = known.test[1]
    assert not (inside & held_out).any()
    assert known.unjudged_shares == pytest.approx([1 - inside.sum() / data.test[1].sum()])
    assert known.weights is data.weights


@pytest.mark.parametrize("improves", [True, False])
def test_rows_are_held_out_in_turn_only_where_both_halves_improve(improves: bool) -> None:
    def offset(motion: Motion) -> Floats:
        return 0.3 + 0 * motion.position

    train = building.record(noise=0.05, seed=0, extra=offset, name="train")
    held_out = building.record(noise=0.05, seed=1, extra=offset if improves else None, name="held out")
    data = building.split([train], [held_out])
    model, base = building.fitted(data, "torque_offset"), building.fitted(data)
    held_out = model.improvement_over(base)
    in_turn = model.improvement_in_turn(base, required=1.5 * abs(held_out.t))
    assert (in_turn.t > held_out.t) is improves
    assert model.improvement_in_turn(base, required=0.9 * abs(held_out.t)) == held_out  # the power is there
