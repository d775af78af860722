"""Effects that only imitate an unknown one are removed."""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.steps import Selection
from ident.diagnosis.search.stepwise_selection import Selector
from ident.diagnosis.unknown.misspecification_check import _with_curves, remove_imitations, remove_pieces
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
    selector = Selector(data, effects, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    selection = selector.select_forced(model, building.start(model), forced)
    result, curves = remove_imitations(selector, selection)
    return selection, curves, result


def test_true_effect_is_kept() -> None:
    selection, _, result = checked(drag, {"drag": building.effect(drag)}, "drag")
    assert result is selection


def test_selection_without_effects_is_kept() -> None:
    selection, _, result = checked(concave, {})
    assert result is selection


def test_effects_that_together_approximate_an_unknown_curve_are_removed() -> None:
    effects = {
        "drag": building.effect(drag),
        "cubic": building.effect(lambda motion: motion.velocity**3),
    }
    selection, _, result = checked(concave, effects, "drag", "cubic")
    assert [step.added for step in selection.steps] == [None, "drag", "cubic"]
    assert [step.added for step in result.steps] == [None]
    assert result.findings == ()


def test_step_with_an_effect_that_was_taken_away_again_does_not_come_back() -> None:
    effects = {"drag": building.effect(drag), "cubic": building.effect(lambda motion: motion.velocity**3)}
    data = building.split([building.record(noise=0.02, extra=concave)])
    selector = Selector(data, effects, lambda text: None)
    model = building.structure(data.recordings[0].recording)
    both, last = (
        selector.select_forced(model, building.start(model), names) for names in (("drag", "cubic"), ("cubic",))
    )
    selection = replace(last, steps=(*both.steps, last.steps[-1]))
    assert [[term.name for term in step.model.terms] for step in selection.steps] == [
        [],
        ["drag"],
        ["drag", "cubic"],
        ["cubic"],
    ]
    assert {number for number, _ in _with_curves(selector, selection, 0)} == {0, 3}


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
    selector = Selector(data, effects, lambda text: None)
    given = building.structure(data.recordings[0].recording).with_term(Term("drag", effects["drag"], (0,)))
    selection = selector.select_forced(given, building.start(given), ())
    assert remove_imitations(selector, selection)[0].steps[0].model.terms == given.terms


def test_two_effects_that_the_motion_hardly_distinguishes_are_not_named() -> None:
    """A stiff end of the travel; a spring and a sine over less than a period add up to nearly the same."""
    effects = {
        "spring": building.effect(lambda motion: motion.position),
        "wave": building.effect(lambda motion: np.sin(motion.position)),
    }
    selection, _, _ = checked(lambda motion: 2 * np.maximum(motion.position, 0.0) ** 2, effects, "spring", "wave")
    result = remove_pieces(Selector(selection.model.split, effects, lambda text: None), selection)
    assert [step.added for step in result.steps] == [None]
    assert "only together with wave" in result.refused["spring"]
    assert "only together with spring" in result.refused["wave"]


def test_two_effects_that_the_motion_distinguishes_are_kept() -> None:
    effects = {"drag": building.effect(drag), "spring": building.effect(lambda motion: motion.position)}
    selection, _, _ = checked(lambda motion: drag(motion) + motion.position, effects, "drag", "spring")
    assert remove_pieces(Selector(selection.model.split, effects, lambda text: None), selection) is selection


def test_two_effects_that_add_up_are_kept_although_the_motion_hardly_distinguishes_them() -> None:
    effects = {
        "spring": building.effect(lambda motion: motion.position),
        "wave": building.effect(lambda motion: np.sin(0.5 * motion.position)),
    }
    for sign, kept in ((1.0, True), (-0.9, False)):
        selection, _, _ = checked(
            lambda motion, sign=sign: 5.0 * motion.position + sign * 10.0 * np.sin(0.5 * motion.position),
            effects,
            "spring",
            "wave",
        )
        result = remove_pieces(Selector(selection.model.split, effects, lambda text: None), selection)
        assert (result is selection) is kept
