"""Confidence intervals of the parameters."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.document.verdict import with_gain
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.split.train_test_split import split_recordings
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Signal, Values
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Bools, Floats
from tests.ident import building

TRUTH = {
    (): building.parameters(),
    ("quadratic_friction",): np.array([*building.parameters(), building.DRAG]),
    ("stribeck",): np.array([*building.parameters(), 0.8, 0.6]),
}
"""True parameters with each effect."""


def _torque(names: tuple[str, ...]) -> building.Torque:
    return lambda motion: (
        building.drag(motion) * ("quadratic_friction" in names)
        + 0.8 * np.exp(-((motion.velocity / 0.6) ** 2)) * motion.direction * ("stribeck" in names)
    )


def _solutions(names: tuple[str, ...], draws: int, noise: float = 0.1) -> Iterator[tuple[SplitData, Solution]]:
    """Fits to recordings that differ in their noise; phase segments are held out."""
    recording = building.record(cycles=4, extra=_torque(names))
    exact, structure = building.prepared(recording), building.structure(recording, *names)
    rng = np.random.default_rng(0)
    for _ in range(draws):
        noisy = building.with_noise(exact, noise * rng.normal(size=recording.position.shape))
        data = split_recordings([noisy], [])
        yield data, data.fit(structure, TRUTH[names])


def _covered(intervals: Floats, names: tuple[str, ...]) -> Bools:
    return (intervals[:, 0] <= TRUTH[names]) & (TRUTH[names] <= intervals[:, 1])


def test_intervals_cover_the_truth() -> None:
    """Four parameters, 1000 draws each: the binomial error of the mean coverage is 0.4 %.

    From one fit of a linear model: the rows, their weights and the regressor stay.
    """
    names, rng, inside = ("quadratic_friction",), np.random.default_rng(0), []
    recording = building.record(cycles=4, noise=0.1, extra=_torque(names))
    data = building.split([recording])
    fitted = building.fitted(data, *names).solution
    (rows, _), (weight,) = fitted.rows(), fitted.weights
    for _ in range(1000):
        drawn = data.predictors[0].prepared.condition(0.1 * rng.normal(size=recording.position.shape))
        shift = np.linalg.lstsq(rows, (weight * drawn)[weight > 0], rcond=None)[0]
        residuals = (drawn - fitted.derivatives[0] @ shift,)
        solution = replace(fitted, x=TRUTH[names] + shift, residuals=residuals)
        inside.append(_covered(FittedModel(data, solution).uncertainty.interval(solution.x), names))
    assert 0.93 <= np.mean(inside) <= 0.97, np.mean(inside, axis=0)


@pytest.mark.slow
@pytest.mark.parametrize("names", TRUTH, ids=["none", "linear", "nonlinear"])
def test_intervals_of_whole_fits_cover_the_truth(names: tuple[str, ...]) -> None:
    """With weights from the data, and a fine encoder. With 150 draws of three to five parameters, the binomial error
    of the mean coverage is 0.8 to 1.0 %.
    """
    inside = [_covered(FittedModel(data, fit).shape_intervals, names) for data, fit in _solutions(names, 150)]
    assert 0.93 <= np.mean(inside) <= 0.97, np.mean(inside, axis=0)


def test_intervals_hold_inertias_that_a_coarse_encoder_attenuates() -> None:
    """The inertia is half a percent too small, always to the same side, and by more than its scatter."""
    for shape in range(4):
        data = building.split([building.record(noise=0.1, seed=shape, shape=shape, encoder_step=3e-4)])
        solution = building.fitted(data).solution
        scatter = FittedModel(data, solution).uncertainty.half_width()[0]
        assert building.INERTIA - solution.x[0] > scatter
        assert _covered(FittedModel(data, solution).shape_intervals, ())[0]


@pytest.mark.parametrize(
    ("changes", "least", "largest"), [({"noise": 0.02}, 1.9, 2.1), ({"encoder_step": 1e-4}, 2.0, np.inf)]
)
def test_noise_and_a_coarse_encoder_widen_the_intervals(
    changes: dict[str, float], least: float, largest: float
) -> None:
    widths = []
    for options in ({}, changes):
        data = building.split([building.record(**{"noise": 0.01, **options})])
        widths.append(np.ptp(building.fitted(data).shape_intervals, axis=1))
    assert (widths[1] > least * widths[0]).all()
    assert (widths[1] < largest * widths[0]).all()


def test_uncertain_gain_widens_the_intervals_of_linear_parameters_only() -> None:
    ((data, solution),) = _solutions(("stribeck",), 1)
    intervals = FittedModel(data, solution).shape_intervals
    exact, uncertain = (np.ptp(with_gain(intervals, solution, share), axis=1) / 2 for share in (0.0, 0.1))
    linear = solution.structure.linear
    expected = np.hypot(exact, 1.96 * 0.1 * np.abs(solution.x) * linear)
    np.testing.assert_allclose(uncertain, expected, rtol=1e-4)
    assert linear.tolist() == [True, True, True, True, False]


def test_what_an_effect_idealizes_widens_the_intervals() -> None:
    """An additional torque of 0.2 N m sgn v (one standard deviation) is an error of Coulomb friction alone."""
    data = building.split([building.record(noise=0.01)])
    texts = dict.fromkeys(("sentence", "symptom", "causes", "remedy", "equation"), "-")
    exact = Signal(**texts, axis="load", parameters=(), report=lambda torque, inputs, values: torque)

    def perturbed(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
        return torque + 0.2 * inputs.motion.direction

    widths = []
    for effect in (exact, replace(exact, perturbed_report=perturbed)):
        structure = data.recordings[0].base_structure.with_term(Term("any", effect, (0,)))
        solution = data.fit(structure, building.start(structure))
        widths.append(np.ptp(FittedModel(data, solution).shape_intervals, axis=1) / 2)
    np.testing.assert_allclose(np.sqrt(widths[1] ** 2 - widths[0] ** 2), [0.0, 0.0, 1.96 * 0.2], atol=1e-3)


def test_parameter_that_others_replace_has_no_interval() -> None:
    """A spring contains an offset: the second of two equal columns is not identifiable."""
    model = building.fitted(building.split([building.record(noise=0.1)]), "joint_spring", "torque_offset")
    known = np.isfinite(model.shape_intervals).all(axis=1)
    assert known.tolist() == [True, True, True, True, True, False]


@pytest.mark.slow
def test_intervals_with_a_coarse_drive_signal_cover_the_truth() -> None:
    """The motion repeats, and so do the errors of its torque: repetitions do not show them. The torque is shifted
    against the steps in each of 120 draws of three parameters: the binomial error of the mean coverage is 1.1 %, if
    they were independent.
    """
    rng, inside = np.random.default_rng(0), []
    for draw in range(120):
        recording = building.record(cycles=4, size=rng.uniform(0.7, 1.3), shape=draw)
        assert recording.effort is not None
        coarse = replace(recording, effort=0.6 * np.rint(recording.effort / 0.6))
        data = building.split([coarse])
        solution = building.fitted(data).solution
        inside.append(_covered(FittedModel(data, solution).shape_intervals, ()))
    assert np.mean(inside) >= 0.92, np.mean(inside, axis=0)
