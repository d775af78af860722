"""Training rows and test rows of recordings, and the effects that they can show."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import convolve2d

from ident.data import row_weights
from ident.data.row_weights import MAX_STANDSTILL
from ident.diagnosis.split.observability import MIN_TEMPERATURE_CHANGE, Observability, observability
from ident.diagnosis.split.split_data import SplitData, rms
from ident.dynamics.effects.library import library
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Axis, Rig
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


def _with_saturation(amplified: float, share: float) -> tuple[Any, Any]:
    """Data of one joint, in which a `share` of the rows amplifies errors by a factor; and a solution."""
    size = np.where(np.arange(1000) < 1000 * share, amplified, 1.0)[:, None]
    prepared = SimpleNamespace(condition=lambda signal: signal, regressor=np.zeros((1000, 1, 3)))
    predictor: Any = SimpleNamespace(prepared=prepared, error_amplification=lambda structure, x, error: size)
    rows = np.ones((1000, 1), bool)
    split = SplitData((predictor, predictor), (rows, ~rows), (~rows, rows), (rows * 1.0, rows * 0.0), True)
    split.__dict__["outside_of_travel"] = (~rows, ~rows)
    term = SimpleNamespace(effect=library()["amplifier_saturation"], joints=(0,))
    return split, SimpleNamespace(structure=SimpleNamespace(terms=(term,)), x=np.zeros(1))


def test_saturated_rows_are_fitted_but_not_scored() -> None:
    all_rows, solution = _with_saturation(amplified=5.0, share=0.1)
    reduced = all_rows.judged(solution, np.ones(1))
    assert reduced.unjudged_shares == pytest.approx((0.1,))
    assert [int(rows.sum()) for rows in (reduced.train[0], reduced.test[1])] == [900, 900]
    assert reduced.weights is all_rows.weights


@pytest.mark.parametrize(("amplified", "share"), [(1.5, 0.5), (5.0, 1.0)])
def test_little_amplification_or_nothing_else_changes_nothing(amplified: float, share: float) -> None:
    all_rows, solution = _with_saturation(amplified, share)
    assert all_rows.judged(solution, np.ones(1)) is all_rows


def test_rows_without_a_prediction_do_not_count() -> None:
    residual = np.array([[3.0], [np.nan], [4.0], [9.0]])
    selected = np.array([[True], [True], [True], [False]])
    assert rms([residual], [selected]) == pytest.approx(np.sqrt(12.5))


@pytest.mark.parametrize("validate", [False, True])
def test_all_rows_are_the_scored_ones_and_those_near_standstill(validate: bool) -> None:
    recordings = [building.record(cycles=3, encoder_step=1e-3, shape=shape) for shape in range(2)]
    split = building.split(recordings[:1], recordings[1:]) if validate else building.split(recordings)
    pairs = [*zip(split.train, split.train_all, strict=True), *zip(split.test, split.test_all, strict=True)]
    assert all(everything[rows].all() for rows, everything in pairs)
    assert sum(int(everything.sum() - rows.sum()) for rows, everything in pairs) > 0
    assert not any((train & test).any() for train, test in zip(split.train_all, split.test_all, strict=True))


def test_creeping_is_standstill_and_a_reversal_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(0.0, 4.0, 1 / 500)
    reverses, touches = np.sin(2 * np.pi * time), 1 + np.cos(np.pi * time)  # the latter at 1 s and 3 s
    taps = np.full((17, 1), 1 / 17)
    recording: Any = SimpleNamespace(
        as_recorded=SimpleNamespace(motion=SimpleNamespace(velocity=np.stack([reverses, touches], axis=1))),
        condition=lambda x: convolve2d(x, taps, "same"),
    )
    monkeypatch.setattr(row_weights, "with_encoder_errors", lambda recording: recording)
    still = row_weights.standstill_share(recording) > MAX_STANDSTILL
    assert not still[:, 0].any()
    around = np.abs(time % 2 - 1)
    assert still[around < 0.05, 1].all()
    assert not still[around > 0.1, 1].any()


def test_joints_without_motion_or_torque_are_refused() -> None:
    short, idle = building.record(2), building.record(2)
    short.position[20:, 1] = short.position[20, 1]
    with pytest.raises(BadInput, match=r"at least 6 held-out samples of every joint .* \d of joint 2"):
        building.split([building.record(2)], [short])
    assert idle.effort is not None
    idle.effort[10:, 1] = 0.0
    with pytest.raises(BadInput, match="that of joint 2 is 0 wherever it moves"):
        building.split([idle])


NAME = "temperature_friction"


def of(recording: Recording, without: tuple[str, ...] = ()) -> Observability:
    return observability(building.split([recording]), library(), without)


def test_an_effect_that_the_user_leaves_out_is_not_tested() -> None:
    result = of(building.record(), ("stribeck",))
    assert "stribeck" not in result.observable
    assert result.untested["stribeck"] == "Left out by the user."


def test_effects_of_other_mechanisms_are_not_sorted() -> None:
    result = of(building.record())
    names = {*result.observable, *result.unobservable, *result.untested}
    assert names == {name for name, effect in library().items() if "axes" in effect.mechanisms}


@pytest.mark.parametrize(
    ("change", "shown"),
    [
        (None, "unobservable"),
        ((0.9 * MIN_TEMPERATURE_CHANGE,), "untested"),
        ((1.1 * MIN_TEMPERATURE_CHANGE,), "observable"),
        ((10.0, np.nan, 0.1), "observable"),
    ],
)
def test_a_temperature_is_observable_on_the_joints_where_it_changes(
    change: tuple[float, ...] | None, shown: str
) -> None:
    """Joints get warmer by `change` [K]; NaN: not measured."""
    share = np.linspace(0, 1, len(building.motion_of().position))[:, None]
    warmer = change and building.record(len(change), temperature=30 + share * np.array(change))
    result = of(warmer or building.record())
    assert [kind for kind, names in vars(result).items() if NAME in names] == [shown]
    if change and len(change) > 1:
        assert result.observable[NAME].joints == (0,)


def test_friction_over_the_position_takes_both_directions() -> None:
    name = "position_dependent_friction"
    assert name in of(building.record()).observable
    assert "one of its directions" in of(building.record(drift=20.0)).untested[name]


def test_a_prismatic_axis_has_neither_turns_nor_a_lever() -> None:
    recording = building.record()
    prismatic = Rig(name="slide", mechanism="axes", axes=(Axis(type="prismatic"),))
    result = of(replace(recording, rig=prismatic))
    assert {"axis_weight", "encoder_eccentricity"} <= set(result.unobservable)
    assert "arm_com_offset" not in result.observable
