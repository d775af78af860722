"""The torque that the amplifiers report, predicted from a motion: whole, in chunks, and as a linear regression."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation import chunks
from ident.estimation.predicted_torque import TorquePredictor
from ident.estimation.regression import Regression, linearize
from recordings.recording import Floats, Recording
from tests.ident import building


@pytest.fixture(scope="module")
def predictor() -> TorquePredictor:
    return TorquePredictor(building.prepared(building.record(2)))


def structure(predictor: TorquePredictor, *names: str) -> tuple[ModelStructure, Floats]:
    """The true mechanism with effects of typical size."""
    model = building.structure(predictor.prepared.recording, *names)
    x = np.array([1.0 if entry.linear else entry.scale for entry in model.parameters])
    x[:6] = building.parameters(2)
    return model, x


def known(x: Floats) -> Floats:
    return np.nan_to_num(x)


def test_true_parameters_predict_the_measured_torque(predictor: TorquePredictor) -> None:
    """Without an effect on the signal, an error of the torque is reported as it is."""
    model, x = structure(predictor)
    np.testing.assert_allclose(known(predictor.torque(model, x) - predictor.prepared.torque), 0.0, atol=0.02)
    slope = predictor.error_amplification(model, x, np.full(2, 0.1))
    np.testing.assert_allclose(slope[np.isfinite(slope)], 1.0, atol=1e-9)


def test_effect_acts_on_its_joints_only(predictor: TorquePredictor) -> None:
    bare, x = structure(predictor)
    term = Term("quadratic_friction", library()["quadratic_friction"], (1,))
    difference = known(predictor.torque(bare.with_term(term), np.append(x, 1.0)) - predictor.torque(bare, x))
    assert np.abs(difference[:, 0]).max() == 0
    assert np.abs(difference[:, 1]).max() > 1


def test_linear_model_is_columns_times_parameters(predictor: TorquePredictor) -> None:
    model, x = structure(predictor, "quadratic_friction", "stribeck")
    torque, derivatives = predictor.linearized(model, x, nonlinear=False)
    np.testing.assert_allclose(known(derivatives @ x), known(torque), atol=1e-9)
    assert not known(derivatives[:, :, ~model.linear]).any()


@pytest.mark.parametrize("name", ["stribeck", "actuation_delay", "torque_gain_mismatch", "encoder_eccentricity"])
def test_derivatives_predict_small_changes(predictor: TorquePredictor, name: str) -> None:
    model, x = structure(predictor, name)
    x[6:] = np.where(model.linear[6:], 1.0, 0.3 * x[6:])
    torque, derivatives = predictor.linearized(model, x)
    change = 1e-3 * np.abs(x) * np.array([entry.free for entry in model.parameters])
    moved = known(predictor.torque(model, x + change) - torque)
    assert np.sqrt(np.mean((moved - known(derivatives @ change)) ** 2)) < 0.05 * np.sqrt(np.mean(moved**2))


def test_cache_changes_nothing() -> None:
    """Alternate between models, with a cache that holds a single entry."""
    prepared = building.prepared(building.record(2))
    small, large = TorquePredictor(prepared, cache_size=1), TorquePredictor(prepared)
    for names in (("stribeck",), ("encoder_eccentricity",), ("stribeck", "joint_spring"), ("stribeck",)):
        model, x = structure(large, *names)
        np.testing.assert_array_equal(small.torque(model, x), large.torque(model, x))
        np.testing.assert_array_equal(small.torque(model, 1.1 * x), large.torque(model, 1.1 * x))


def test_effects_of_one_name_have_their_own_columns() -> None:
    """Curves that are learned one after the other have the same name."""
    prepared = building.prepared(building.record())
    predictor, base = TorquePredictor(prepared), prepared.base_structure
    x = np.array([*building.parameters(), 1.0])
    torques = [
        predictor.torque(base.with_term(Term("curve", building.effect(column), (0,))), x)
        for column in (lambda motion: motion.position, lambda motion: motion.velocity)
    ]
    assert np.nanmax(np.abs(torques[0] - torques[1])) > 0.1


def test_mechanism_without_effects_is_its_own_regression() -> None:
    prepared = building.prepared(building.record(2))
    linear = linearize(prepared, building.structure(prepared.recording), np.zeros(6))
    np.testing.assert_array_equal(linear.regressor, prepared.regressor)
    assert linear.offset is None
    assert np.nanstd(linear.residual(building.parameters(2))) < 0.02


@pytest.mark.parametrize("name", ["stribeck", "actuation_delay", "encoder_eccentricity"])
def test_prediction_at_its_own_parameters_is_that_of_the_model(name: str) -> None:
    prepared = building.prepared(building.record(2))
    structure = building.structure(prepared.recording, name)
    x = np.array([0.5 if entry.linear else 0.3 * entry.scale for entry in structure.parameters])
    linear = linearize(prepared, structure, x)
    predicted, expected = linear.predicted_torque(x[structure.linear]), TorquePredictor(prepared).torque(structure, x)
    known = np.isfinite(predicted)
    assert known.mean() > 0.9
    np.testing.assert_allclose(predicted[known], expected[known], atol=1e-9)
    assert (linear.offset is None) == (name == "stribeck")


def test_rows_are_usable_ones_joint_after_joint_without_the_offset() -> None:
    recording = building.record(2)
    assert recording.effort is not None
    recording.effort[500:600, 1] = np.nan
    prepared = building.prepared(recording)
    shifted = Regression(prepared, prepared.regressor, prepared.torque, np.full_like(prepared.torque, 0.25))
    regressor, torque = shifted.rows()
    counts = prepared.usable.sum(axis=0)
    assert counts[1] < counts[0]
    assert len(torque) == len(regressor) == counts.sum()
    np.testing.assert_allclose(torque[: counts[0]], prepared.torque[prepared.usable[:, 0], 0] - 0.25)
    np.testing.assert_allclose(torque[counts[0] :], prepared.torque[prepared.usable[:, 1], 1] - 0.25)


@pytest.mark.parametrize("names", [(), ("rod_inertia", "stribeck", "thermal_drift"), ("presliding_hysteresis",)])
@pytest.mark.parametrize(("size", "sign"), [(1234, 1.0), (3001, 1.0), (1234, -1.0)])
def test_chunks_give_the_same_torque_and_derivatives_as_the_whole(
    names: tuple[str, ...], size: int, sign: float, make: Callable[..., Recording], monkeypatch: pytest.MonkeyPatch
) -> None:
    recording = make(rate=500.0, cycles=3, noise=0.01)
    position = recording.position.copy()
    position[2000:2004, 1] = np.nan
    prepared = prepare(Recording(**{**vars(recording), "position": position}), "parallel", 30.0)
    structure, effects = ModelStructure(prepared.as_recorded.mechanism, prepared.as_recorded.rig), library()
    for name in names:
        structure = structure.with_term(Term(name, effects[name], (0, 1, 2)))
    # A negative time constant: friction grows until the end of the recording, not of a chunk.
    x = np.array([1.0 if entry.linear else sign * entry.scale for entry in structure.parameters])
    expected = TorquePredictor(prepared).linearized(structure, x, nonlinear=False)
    monkeypatch.setattr(chunks, "CHUNK_LENGTH", size)
    assert len(list(chunks.overlapping_chunks(prepared))) > 2
    torque, derivatives = chunks.linearized(prepared, structure, x)
    np.testing.assert_allclose(torque, expected[0], rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(derivatives, expected[1][:, :, structure.linear], rtol=1e-9, atol=1e-9)
    np.testing.assert_array_equal(chunks.torque(prepared, structure, x), torque)
