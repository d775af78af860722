"""The torque that the amplifiers report, predicted from a motion."""

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats
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
    model, x = structure(predictor)
    measured = predictor.prepared.torque
    np.testing.assert_allclose(known(predictor.torque(model, x) - measured), 0.0, atol=0.02)


def test_torque_is_the_conditioned_unfiltered_one(predictor: TorquePredictor) -> None:
    model, x = structure(predictor, "stribeck")
    expected = predictor.prepared.condition(predictor.unfiltered(model, x))
    np.testing.assert_array_equal(predictor.torque(model, x), expected)


def test_additive_effects_add_up(predictor: TorquePredictor) -> None:
    bare, x = structure(predictor)
    torque = predictor.torque(bare, x)
    parts = []
    for names in (("quadratic_friction",), ("joint_spring",), ("quadratic_friction", "joint_spring")):
        model, values = structure(predictor, *names)
        parts.append(known(predictor.torque(model, values) - torque))
    np.testing.assert_allclose(parts[0] + parts[1], parts[2], atol=1e-9)


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


def test_gain_amplifies_errors_by_its_slope(predictor: TorquePredictor) -> None:
    """Without an effect on the signal, an error of the torque is reported as it is."""
    model, x = structure(predictor)
    slope = predictor.error_amplification(model, x, np.full(2, 0.1))
    np.testing.assert_allclose(slope[np.isfinite(slope)], 1.0, atol=1e-9)


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
