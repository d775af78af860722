"""Screening: what each effect of a library could explain, by linear algebra."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.search.screening import Candidate, Screener
from ident.diagnosis.search.selection import Exclusion, FittedModel
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

LIBRARY = library()


def effects(*names: str) -> dict[str, Effect]:
    return {name: LIBRARY[name] for name in names}


def drag(motion: Motion) -> Floats:
    return 0.5 * motion.velocity * np.abs(motion.velocity)


def screened(data: SplitData, model: FittedModel, *names: str) -> tuple[dict[str, Candidate], dict[str, Exclusion]]:
    candidates, excluded = Screener(data, model.solution).screen(effects(*names))
    return {candidate.term.name: candidate for candidate in candidates}, excluded


def test_promised_loss_of_a_linear_effect_is_that_of_the_fit() -> None:
    data = building.split([building.record(2, noise=0.05, extra=drag)])
    candidate = screened(data, building.fitted(data), "quadratic_friction")[0]["quadratic_friction"]
    fitted = building.fitted(data, "quadratic_friction")
    assert candidate.loss == pytest.approx(fitted.solution.loss, rel=1e-6)
    np.testing.assert_allclose(candidate.coefficients, fitted.solution.x[-2:], rtol=1e-4)
    np.testing.assert_allclose(candidate.initial_guesses[0], candidate.coefficients)


def test_true_effect_is_the_most_promising_and_only_on_its_joint() -> None:
    data = building.split([building.record(2, 6, noise=0.05, extra=lambda motion: drag(motion) * [1.0, 0.0])])
    model = building.fitted(data)
    candidates, _ = Screener(data, model.solution).screen(
        effects("torque_offset", "joint_spring", "quadratic_friction")
    )
    assert candidates[0].term.name == "quadratic_friction"
    assert 0 in candidates[0].term.joints
    assert [candidate.loss for candidate in candidates] == sorted(candidate.loss for candidate in candidates)
    assert all(candidate.loss <= model.solution.loss for candidate in candidates)


@pytest.mark.parametrize("joints", [(0,), (0, 1)])
def test_promised_loss_counts_the_friction_that_an_effect_replaces(joints: tuple[int, ...]) -> None:
    """The shape is kept, so that the fit is linear, too."""
    weights = np.isin([0, 1], joints)

    def power(motion: Motion) -> Floats:
        law = np.abs(motion.velocity) ** 0.55 * motion.direction - building.VISCOUS * motion.velocity
        return law * weights

    data = building.split([building.record(2, noise=0.05, extra=power)])
    candidate = screened(data, building.fitted(data), "power_law_friction")[0]["power_law_friction"]
    assert candidate.term.joints == joints
    x = np.concatenate([building.fitted(data).solution.x, candidate.initial_guesses[0]])
    fitted = data.fit_linear(building.structure(data.recordings[0].recording, "power_law_friction", joints=joints), x)
    assert candidate.loss == pytest.approx(fitted.loss, rel=1e-6)
    np.testing.assert_allclose(candidate.coefficients, fitted.x[-1 - len(joints) : -1], rtol=1e-6)
    assert np.count_nonzero(fitted.x[2:4]) == 2 - len(joints)


def test_effect_that_the_model_contains_already_is_collinear() -> None:
    data = building.split([building.record(2, noise=0.05, extra=drag)])
    _, excluded = screened(data, building.fitted(data, "quadratic_friction"), "quadratic_friction")
    assert excluded == {"quadratic_friction": "collinear"}


def test_impossible_sign_is_excluded() -> None:
    """Friction that drives the motion."""
    data = building.split([building.record(noise=0.05, extra=lambda motion: -drag(motion))])
    _, excluded = screened(data, building.fitted(data), "quadratic_friction")
    assert excluded == {"quadratic_friction": "sign"}


def test_initial_shape_near_the_truth_is_found() -> None:
    def stribeck(motion: Motion) -> Floats:
        bump: Floats = np.exp(-((motion.velocity / 0.8) ** 2)) * motion.direction
        return bump

    data = building.split([building.record(cycles=6, noise=0.02, extra=stribeck)])
    candidate = screened(data, building.fitted(data), "stribeck")[0]["stribeck"]
    assert candidate.shapes == pytest.approx([0.8])
    assert candidate.coefficients == pytest.approx([1.0], rel=0.1)
    assert candidate.parameter_count == 2


def test_signal_effect_is_extrapolated_to_the_true_delay() -> None:
    """A drive signal that is 8 ms late."""
    late = building.record(cycles=6, noise=0.01)
    assert late.effort is not None
    late.effort[2:] = late.effort[:-2].copy()
    data = building.split([late])
    model = building.fitted(data)
    candidate = screened(data, model, "actuation_delay")[0]["actuation_delay"]
    assert min(abs(abs(guess[0]) - 0.008) for guess in candidate.initial_guesses) < 0.004
    assert candidate.loss < 0.5 * model.solution.loss


def test_screening_does_not_depend_on_the_unit_of_torque() -> None:
    data = building.split([building.record(noise=0.05, extra=drag)])
    tenfold = building.record(noise=0.05, extra=drag)
    assert tenfold.effort is not None
    tenfold.effort[:] *= 10.0
    scaled = building.split([tenfold])
    first, second = (screened(x, building.fitted(x), "quadratic_friction")[0] for x in (data, scaled))
    np.testing.assert_allclose(
        second["quadratic_friction"].coefficients, 10 * first["quadratic_friction"].coefficients, rtol=1e-6
    )
    assert second["quadratic_friction"].loss == pytest.approx(first["quadratic_friction"].loss, rel=1e-6)


def test_what_several_recordings_suggest_is_tried_once() -> None:
    late = replace(LIBRARY["actuation_delay"], multistart=9, suggest=lambda inputs, residual: [{"delta": 0.004}])
    data = building.split([building.record(noise=0.05, extra=drag)] * 3)
    (candidate,), _ = Screener(data, building.fitted(data).solution).screen({"late": late})
    assert len({guess.tobytes() for guess in candidate.initial_guesses}) == len(candidate.initial_guesses) > 1
