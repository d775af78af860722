"""Effects that only imitate an unknown one are removed."""

import numpy as np

from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown.imitation import remove_imitations
from ident.diagnosis.unknown.nonparametric_fit import NonparametricFit
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


def cable(motion: Motion) -> Floats:
    """An elastic cable between two joints: half of its torque is a spring's."""
    return 2.0 * (motion.position - motion.position[:, ::-1])


def checked(
    torque: building.Torque, effects: dict[str, Effect], *forced: str, joints: int = 1
) -> tuple[Selection, NonparametricFit | None, Selection]:
    """The selection of `forced` effects before the check, the curves that replace effects, and that after it."""
    data = building.split([building.record(joints, noise=0.02, extra=torque)])
    selector = Search(data, effects, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    selection = selector.select_forced(model, building.start(model), forced)
    result, curves = remove_imitations(selector, selection, None)
    return selection, curves, result


def test_true_effect_is_kept() -> None:
    selection, _, result = checked(drag, {"drag": building.effect(drag)}, "drag")
    assert result is selection


def test_selection_without_effects_is_kept() -> None:
    selection, _, result = checked(concave, {})
    assert result is selection


def test_curve_over_the_own_motion_never_removes_a_name() -> None:
    """Load, pre-sliding and low speed are functions of it: such a curve approximates whatever depends on them."""
    effects = {"drag": building.effect(drag), "cubic": building.effect(lambda motion: motion.velocity**3)}
    selection, _, result = checked(concave, effects, "drag", "cubic")
    assert [step.added for step in selection.steps] == [None, "drag", "cubic"]
    assert result is selection


def test_effect_that_is_a_part_of_an_unknown_one_is_removed() -> None:
    """What it leaves is a curve of the other joint's position; with one of its own, too, the curve contains it."""
    effects = {"spring": building.effect(lambda motion: motion.position)}
    selection, curves, result = checked(cable, effects, "spring", joints=2)
    assert [step.added for step in selection.steps] == [None, "spring"]
    assert [step.added for step in result.steps] == [None]
    assert curves is not None
    assert {(each.joint, each.variables) for each in curves.dependences} == {
        (0, ("position", "joint_2")),
        (1, ("position", "joint_1")),
    }
    assert all(each.explained > 0.9 for each in curves.dependences)


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
    assert remove_imitations(selector, selection, None)[0].steps[0].model.terms == given.terms
