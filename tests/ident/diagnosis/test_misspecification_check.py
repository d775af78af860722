"""Effects that only imitate an unknown one are removed."""

import numpy as np

from ident.diagnosis.misspecification_check import remove_imitations
from ident.diagnosis.steps import Selection
from ident.diagnosis.stepwise_selection import Selector
from ident.dynamics.effects.base import Effect
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.recording import Floats
from tests.ident import building


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * np.abs(motion.velocity)


def concave(motion: Motion) -> Floats:
    """Friction that rises steeply at first, then hardly, with a bump: no effect of these tests."""
    v = np.abs(motion.velocity)
    return (1.5 * np.sqrt(v) + 0.8 * np.sin(2.5 * v)) * motion.direction


def checked(torque: building.Torque, effects: dict[str, Effect], *forced: str) -> tuple[Selection, Selection]:
    """The selection of `forced` effects, before and after the check."""
    data = building.split([building.record(noise=0.02, extra=torque)])
    selector = Selector(data, effects, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    selection = selector.select_forced(model, building.start(model), forced)
    return selection, remove_imitations(selector, selection)


def test_true_effect_is_kept() -> None:
    selection, result = checked(drag, {"drag": building.effect(drag)}, "drag")
    assert result is selection


def test_selection_without_effects_is_kept() -> None:
    selection, result = checked(concave, {})
    assert result is selection


def test_effects_that_together_approximate_an_unknown_curve_are_removed() -> None:
    effects = {
        "drag": building.effect(drag),
        "cubic": building.effect(lambda motion: motion.velocity**3),
    }
    selection, result = checked(concave, effects, "drag", "cubic")
    assert [step.added for step in selection.steps] == [None, "drag", "cubic"]
    assert [step.added for step in result.steps] == [None]
    assert result.findings == ()


def test_mandatory_effect_is_never_removed() -> None:
    """That a curve explains more beside it is no reason against it."""
    effects = {"drag": building.effect(drag, mandatory=True)}
    _, result = checked(lambda motion: 3 * drag(motion) + concave(motion), effects)
    assert {term.name for term in result.steps[-1].model.terms} == {"drag"}


def test_effects_of_a_given_model_are_kept() -> None:
    data = building.split([building.record(noise=0.02, extra=concave)])
    effects = {"drag": building.effect(drag)}
    selector = Selector(data, effects, lambda text: None)
    given = building.structure(data.recordings[0].recording).with_term(Term("drag", effects["drag"], (0,)))
    selection = selector.select_forced(given, building.start(given), ())
    assert remove_imitations(selector, selection).steps[0].model.terms == given.terms
