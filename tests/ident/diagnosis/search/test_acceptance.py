"""Which of several extensions of a model is accepted."""

from dataclasses import replace

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.acceptance import MIN_ADDED_SHARE, Acceptance
from ident.diagnosis.search.candidate_search import CandidateSearch
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * np.abs(motion.velocity)


def nearly_drag(motion: Motion) -> Floats:
    return drag(motion) * (1 + 0.01 * np.cos(motion.position))


def wave(motion: Motion) -> Floats:
    return np.cos(4 * motion.position)


def models(
    torque: building.Torque, *columns: building.Torque
) -> tuple[Acceptance, FittedModel, dict[str, FittedModel]]:
    """A recording with `torque`: the model without effects, and one with each of the `columns` that shows."""
    data = building.split([building.record(noise=0.05, extra=torque)])
    effects = {each.__name__: building.effect(each) for each in columns}
    search = CandidateSearch(data, effects)
    bare = building.structure(data.recordings[0].recording)
    model = search.fit(bare, building.start(bare))
    extended = {extension.terms[-1].name: extension for extension in search.extensions(model).models}
    return Acceptance(data, search), model, extended


def test_effect_that_the_data_contain_is_confirmed_and_nothing_is_left() -> None:
    acceptance, model, extended = models(drag, drag, wave)
    assert acceptance.leaves_much(model)
    assert acceptance.is_confirmed(model, extended["drag"])
    assert not acceptance.leaves_much(extended["drag"])
    assert acceptance.is_far_better(extended["drag"], model)
    assert acceptance.first_confirmed(model, list(extended.values())) is extended["drag"]


def test_effect_that_explains_nothing_is_not_confirmed() -> None:
    acceptance, model, extended = models(lambda motion: 0 * drag(motion), drag)
    assert extended == {}
    zero = np.zeros(len(model.solution.x) + 1)
    wider = building.structure(model.split.recordings[0].recording, "quadratic_friction")
    useless = FittedModel(model.split, model.split.fit(wider, zero))
    assert not acceptance.is_confirmed(model, useless)
    assert acceptance.first_confirmed(model, [useless]) is None


@pytest.mark.parametrize("size", [0.0, 1.0])
def test_small_effect_is_minor_only_beside_a_large_error(size: float) -> None:
    acceptance, model, extended = models(lambda motion: drag(motion) / 6 + size * wave(motion), drag)
    assert acceptance.is_minor(model, extended["drag"]) == (size > 0)


def test_effect_that_explains_most_of_the_training_rows_is_not_minor() -> None:
    """Whatever else the held-out motion shows."""
    held_out = building.record(noise=0.05, shape=1, extra=lambda motion: drag(motion) + 5 * wave(motion))
    data = building.split([building.record(noise=0.05, extra=drag)], [held_out])
    search = CandidateSearch(data, {"drag": building.effect(drag)})
    bare = building.structure(data.recordings[0].recording)
    model = search.fit(bare, building.start(bare))
    extended = search.extensions(model).models[0]
    assert extended.improvement_over(model).share < MIN_ADDED_SHARE
    assert not Acceptance(data, search).is_minor(model, extended)


def test_model_with_a_larger_noise_floor_of_its_own_is_not_far_better() -> None:
    """Where nothing repeats, what a model leaves raises the floor that it is measured by."""
    acceptance, model, _ = models(drag, wave)
    same = replace(model)
    same.__dict__["noise_floor"] = replace(model.noise_floor, noise=3 * model.noise_floor.rms)
    assert not acceptance.is_far_better(same, model)


@pytest.mark.parametrize(("share", "joints"), [(0.0, (0,)), (0.15, (0, 1))])
def test_small_effect_of_a_further_joint_stays_only_if_it_is_confirmed(share: float, joints: tuple[int, ...]) -> None:
    data = building.split([building.record(2, noise=0.02, extra=lambda motion: drag(motion) * (1.0, share))])
    acceptance = Acceptance(data, CandidateSearch(data, library()))
    model = building.fitted(data, "quadratic_friction")
    assert acceptance.without_minor_joints(model).terms[0].joints == joints


def test_extensions_that_explain_alike_are_equivalent() -> None:
    acceptance, model, extended = models(drag, drag, nearly_drag, wave)
    names = {each.terms[-1].name for each in acceptance.equivalent(model.solution.loss, list(extended.values()))}
    assert names >= {"drag", "nearly_drag"}
    assert "wave" not in names
