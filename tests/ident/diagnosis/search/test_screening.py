"""Screening: what each effect of a library could explain, by linear algebra, and on which joints."""

import numpy as np
import pytest

from ident.diagnosis.search.joint_subsets import Products, choose_joints
from ident.diagnosis.search.screening import Candidate, Screener, initial_guesses
from ident.diagnosis.search.selection import Exclusion, FittedModel
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.recording import Floats
from tests.ident import building
from tests.ident.building import drag

LIBRARY = library()


def effects(*names: str) -> dict[str, Effect]:
    return {name: LIBRARY[name] for name in names}


def screened(data: SplitData, model: FittedModel, *names: str) -> tuple[dict[str, Candidate], dict[str, Exclusion]]:
    screening = Screener(data, model.solution).screen(effects(*names))
    return screening.best, dict(screening.excluded)


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
    library = effects("torque_offset", "joint_spring", "quadratic_friction")
    candidates = Screener(data, model.solution).screen(library).candidates
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


@pytest.mark.parametrize(("sign", "present", "reason"), [(1, ("quadratic_friction",), "collinear"), (-1, (), "sign")])
def test_effect_of_the_model_or_of_an_impossible_sign_is_excluded(
    sign: int, present: tuple[str, ...], reason: str
) -> None:
    data = building.split([building.record(2, noise=0.05, extra=lambda motion: sign * drag(motion))])
    _, excluded = screened(data, building.fitted(data, *present), "quadratic_friction")
    assert excluded == {"quadratic_friction": reason}


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


def test_suggested_parameters_are_tried_after_the_declared_ones_and_once() -> None:
    """Coefficients of columns start at one; parameters of signals, and shapes, where the effect declares."""
    delay, stribeck = (
        Term.on_all_joints(name, LIBRARY[name], building.bench(2)) for name in ("actuation_delay", "stribeck")
    )
    late = [local for local, _ in initial_guesses(delay, [{"delta": 0.004}, {"delta": 0.004}])]
    declared = delay.local_parameters[0].initial_guesses
    assert [local.tolist() for local in late] == [[[guess]] * delay.instances for guess in (*declared, 0.004)]
    guesses = initial_guesses(stribeck, [{"v_s": 0.123}])
    assert [shapes.tolist() for _, shapes in guesses] == [[v] for v in (*stribeck.shapes[0].initial_guesses, 0.123)]
    assert all((local == np.ones((2, 1))).all() for local, _ in guesses)


@pytest.mark.parametrize(
    ("strengths", "positive", "chosen"),
    [
        ([2.0, 0.01, -1.0], False, (0, 2)),  # a joint that adds little is left out
        ([1.0, -1.0], True, (0,)),  # and one with an impossible sign
        ([-1.0], True, None),
        ([1.0, 0.0, 0.0, 1.0], False, (0, 3)),
        ([1.0, 0.0, 0.0, 1.0, 0.0, 0.5], False, (0, 3, 5)),  # however many joints there are
    ],
)
def test_joints_that_add_much_with_a_possible_sign_are_chosen(
    strengths: list[float], positive: bool, chosen: tuple[int, ...] | None
) -> None:
    """Columns that are nearly orthogonal, times the strength on each joint."""
    columns = np.random.default_rng(3).normal(size=(60, len(strengths)))
    residual = columns @ strengths
    products = Products(columns.T @ columns, columns.T @ residual, 0.0, np.full(1, 1.0 * positive), np.arange(0))
    choice = choose_joints(products, range(len(strengths)))
    assert (choice and choice[0]) == chosen
    if choice and not positive:
        np.testing.assert_allclose(choice[2], np.array(strengths)[list(choice[0])], atol=0.01)


@pytest.mark.parametrize(
    ("strengths", "chosen"),
    [
        ([2.0, -0.01, 1.0, 1.0], (0, 1)),
        ([2.0, -0.01, -1.0, -1.0], (0,)),
        ([-2.0, -0.01, -1.0, -1.0], None),
    ],
)
def test_of_several_coefficients_with_a_sign_one_may_be_zero(
    strengths: list[float], chosen: tuple[int, ...] | None
) -> None:
    """Two joints with two coefficients each; those of the wrong sign are zero, and the others fitted without them."""
    columns = np.random.default_rng(3).normal(size=(60, 4))
    residual = columns @ strengths
    products = Products(columns.T @ columns, columns.T @ residual, 0.0, np.ones(2), np.arange(0))
    choice = choose_joints(products, range(2))
    assert (choice and choice[0]) == chosen
    if choice:
        own = [2 * joint + column for joint in choice[0] for column in range(2)]
        positive = [entry for entry in own if strengths[entry] > 0]
        fitted = np.linalg.lstsq(columns[:, positive], residual, rcond=None)[0]
        np.testing.assert_allclose(choice[2][np.isin(own, positive)], fitted)
        assert not choice[2][~np.isin(own, positive)].any()
