"""Effects that only imitate an unknown one are left out."""

import numpy as np

from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown.imitation import analyse_unexplained
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit
from ident.dynamics.effects.base import Effect
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.recording import Floats
from tests.ident import building


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * np.abs(motion.velocity)


def concave(motion: Motion) -> Floats:
    """Friction that rises ever less: no effect of these tests."""
    return 1.5 * np.sqrt(np.abs(motion.velocity)) * motion.direction


def cable(motion: Motion) -> Floats:
    """A cable that the other joint pulls."""
    return 2.0 * np.sin(motion.position[:, ::-1] + 0.5)


def checked(
    torque: building.Torque, effects: dict[str, Effect], *forced: str, joints: int = 1
) -> tuple[Selection, NonparametricFit | None, Selection]:
    """The selection of `forced` effects before the check, the curves that replace effects, and that after it."""
    data = building.split([building.record(joints, noise=0.02, extra=torque)])
    selector = Search(data, effects, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    selection = selector.select_forced(model, building.start(model), forced)
    result, _, curves = analyse_unexplained(selector, selection, forced=False)
    return selection, curves, result


def test_true_effect_is_kept() -> None:
    selection, _, result = checked(drag, {"drag": building.effect(drag)}, "drag")
    assert result is selection


def test_selection_without_effects_is_kept() -> None:
    selection, _, result = checked(concave, {})
    assert result is selection


def test_effects_that_approximate_an_unknown_one_together_are_left_out() -> None:
    """Beside a curve over the speed, none of them explains anything."""
    effects = {"drag": building.effect(drag), "cubic": building.effect(lambda motion: motion.velocity**3)}
    selection, curves, result = checked(concave, effects, "drag", "cubic")
    assert [step.added for step in selection.steps] == [None, "drag", "cubic"]
    assert [step.added for step in result.steps] == [None]
    assert result.rejected["drag"].why.endswith("curves over velocity leave nothing of it to explain.")
    assert curves is not None
    assert curves.supported


def test_requested_effects_stay() -> None:
    data = building.split([building.record(1, noise=0.02, extra=concave)])
    selector = Search(data, {"drag": building.effect(drag)}, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    selection = selector.select_forced(model, building.start(model), ["drag"])
    assert analyse_unexplained(selector, selection, forced=True)[0] is selection


def test_effect_that_imitates_what_another_joint_does_is_left_out() -> None:
    """The joints move together, so that a spring of its own takes a part of what the other one pulls."""
    effects = {"spring": building.effect(lambda motion: motion.position)}
    selection, curves, result = checked(cable, effects, "spring", joints=2)
    assert [step.added for step in selection.steps] == [None, "spring"]
    assert [step.added for step in result.steps] == [None]
    assert curves is not None
    assert (1, ("position", "joint_1")) in {(each.joint, each.variables) for each in curves.dependences}


def test_effect_beside_an_unknown_one_of_another_variable_is_kept() -> None:
    effects = {"spring": building.effect(lambda motion: motion.position)}
    selection, _, result = checked(lambda motion: concave(motion) + 2 * motion.position, effects, "spring")
    assert result is selection


def test_mandatory_effect_is_never_removed() -> None:
    """That a curve explains more beside it is no reason against it."""
    effects = {"drag": building.effect(drag, mandatory=True)}
    _, _, result = checked(lambda motion: 3 * drag(motion) + concave(motion), effects)
    assert {term.name for term in result.steps[-1].model.terms} == {"drag"}


def test_effects_of_a_given_model_are_kept() -> None:
    data = building.split([building.record(noise=0.02, extra=concave)])
    effects = {"drag": building.effect(drag)}
    selector = Search(data, effects, lambda text: None)
    given = building.structure(data.recordings[0].recording).with_term(Term("drag", effects["drag"], (0,)))
    selection = selector.select_forced(given, building.start(given), ())
    assert analyse_unexplained(selector, selection, forced=False)[0].steps[0].model.terms == given.terms
