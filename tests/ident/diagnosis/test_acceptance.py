"""Which of several extensions of a model is accepted."""

import numpy as np
import pytest

from ident.diagnosis.acceptance import Acceptance
from ident.diagnosis.candidate_search import CandidateSearch
from ident.diagnosis.steps import FittedModel
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


def test_extensions_that_explain_alike_are_equivalent() -> None:
    acceptance, model, extended = models(drag, drag, nearly_drag, wave)
    names = {each.terms[-1].name for each in acceptance.equivalent(model.solution.loss, list(extended.values()))}
    assert names >= {"drag", "nearly_drag"}
    assert "wave" not in names
