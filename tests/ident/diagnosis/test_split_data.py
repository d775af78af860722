"""Training rows and test rows of recordings."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import convolve2d

from ident.diagnosis import split_data
from ident.diagnosis.split_data import SplitData, rms
from ident.dynamics.effects.library import library
from recordings.errors import BadInput
from tests.ident import building


def test_errors_in_a_regressor_attenuate_the_parameters() -> None:
    rng = np.random.default_rng(0)
    measured = rng.normal(size=(20_000, 1, 1))
    perturbed = measured + 0.5 * rng.normal(size=measured.shape)
    train = np.ones((len(measured), 1), bool)
    predictors = [
        SimpleNamespace(linearized=lambda bare, x, columns=columns: (None, columns))
        for columns in (measured, perturbed)
    ]
    split: Any = SplitData((predictors[0],), (train,), (~train,), (np.where(train, 3.0, 0.0),), True)  # type: ignore[arg-type]
    split.__dict__["perturbed"] = (predictors[1],)
    columns, bias = split.perturbed_regressors(SimpleNamespace(terms=(), parameters=(None,)))
    assert columns == [(measured, perturbed)]
    # -E[perturbed (perturbed - measured)] / E[perturbed^2]
    assert bias == pytest.approx(-0.25 / 1.25, rel=0.05)


@pytest.mark.parametrize("validate", [False, True])
def test_all_rows_are_the_scored_ones_and_those_near_standstill(validate: bool) -> None:
    recordings = [building.record(cycles=3, encoder_step=1e-3, shape=shape) for shape in range(2)]
    split = building.split(recordings[:1], recordings[1:]) if validate else building.split(recordings)
    pairs = [*zip(split.train, split.train_all, strict=True), *zip(split.test, split.test_all, strict=True)]
    assert all(everything[rows].all() for rows, everything in pairs)
    assert sum(int(everything.sum() - rows.sum()) for rows, everything in pairs) > 0
    assert not any((train & test).any() for train, test in zip(split.train_all, split.test_all, strict=True))


def _with_saturation(amplified: float, share: float) -> tuple[Any, Any]:
    """Data of one joint, in which a `share` of the rows amplifies errors by a factor; and a solution."""
    size = np.where(np.arange(1000) < 1000 * share, amplified, 1.0)[:, None]
    prepared = SimpleNamespace(condition=lambda signal: signal, regressor=np.zeros((1000, 1, 3)))
    predictor: Any = SimpleNamespace(prepared=prepared, error_amplification=lambda structure, x, error: size)
    rows = np.ones((1000, 1), bool)
    split = SplitData((predictor, predictor), (rows, ~rows), (~rows, rows), (rows * 1.0, rows * 0.0), True)
    term = SimpleNamespace(effect=library()["amplifier_saturation"])
    return split, SimpleNamespace(structure=SimpleNamespace(terms=(term,)), x=np.zeros(1))


def test_saturated_rows_are_fitted_but_not_scored() -> None:
    all_rows, solution = _with_saturation(amplified=5.0, share=0.1)
    reduced = all_rows.without_saturated_rows(solution, np.ones(1))
    assert reduced.insensitive_share == pytest.approx(0.1)
    assert [int(rows.sum()) for rows in (reduced.train[0], reduced.test[1])] == [900, 900]
    assert reduced.weights is all_rows.weights


@pytest.mark.parametrize(("amplified", "share"), [(1.5, 0.5), (5.0, 0.005), (5.0, 1.0)])
def test_little_or_rare_amplification_or_nothing_else_changes_nothing(amplified: float, share: float) -> None:
    all_rows, solution = _with_saturation(amplified, share)
    assert all_rows.without_saturated_rows(solution, np.ones(1)) is all_rows


def test_rows_without_a_prediction_do_not_count() -> None:
    residual = np.array([[3.0], [np.nan], [4.0], [9.0]])
    selected = np.array([[True], [True], [True], [False]])
    assert rms([residual], [selected]) == pytest.approx(np.sqrt(12.5))


def test_creeping_is_standstill_and_a_reversal_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(0.0, 4.0, 1 / 500)
    reverses, touches = np.sin(2 * np.pi * time), 1 + np.cos(np.pi * time)  # the latter at 1 s and 3 s
    taps = np.full((17, 1), 1 / 17)
    recording: Any = SimpleNamespace(
        as_recorded=SimpleNamespace(motion=SimpleNamespace(velocity=np.stack([reverses, touches], axis=1))),
        condition=lambda x: convolve2d(x, taps, "same"),
    )
    monkeypatch.setattr(split_data, "with_encoder_errors", lambda recording: recording)
    still = split_data.standstill_share(recording) > split_data.MAX_STANDSTILL
    assert not still[:, 0].any()
    around = np.abs(time % 2 - 1)
    assert still[around < 0.05, 1].all()
    assert not still[around > 0.1, 1].any()


def test_joint_that_hardly_moves_is_refused() -> None:
    short = building.record(2)
    short.position[20:, 1] = short.position[20, 1]
    with pytest.raises(BadInput, match=r"at least 6 held-out samples of every joint .* \d of joint 2"):
        building.split([building.record(2)], [short])


def test_joint_without_torque_in_motion_is_refused() -> None:
    recording = building.record(2)
    assert recording.effort is not None
    recording.effort[10:, 1] = 0.0
    with pytest.raises(BadInput, match="that of joint 2 is 0 wherever it moves"):
        building.split([recording])


@pytest.mark.parametrize("kept", [0, 1000])
def test_rows_are_scored_where_none_is_extrapolated_or_hardly_any_is_left(kept: int) -> None:
    data, _ = _with_saturation(amplified=1.0, share=0.0)
    unknown = np.arange(1000)[:, None] >= kept
    assert data.without_extrapolated_rows((unknown, unknown)) is data
