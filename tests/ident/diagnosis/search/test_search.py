"""Stepwise selection on recordings of one axis with planted effects."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.search.search import Search
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats
from tests.ident import building

Torque = Callable[[Motion], Floats]
LIBRARY = library()
USUAL = {name: LIBRARY[name] for name in ("torque_offset", "quadratic_friction", "joint_spring", "stribeck")}


def drag(motion: Motion) -> Floats:
    return 0.3 * motion.velocity * np.abs(motion.velocity)


def spring(motion: Motion) -> Floats:
    return 1.2 * motion.position


def offset(motion: Motion) -> Floats:
    return np.full_like(motion.position, 0.4)


def ripple(motion: Motion) -> Floats:
    """A torque that no effect of these tests explains."""
    return np.cos(4 * motion.position)


def imitation(motion: Motion) -> Floats:
    """Drag and spring with a ripple."""
    return drag(motion) + spring(motion) + 0.5 * ripple(motion)


def split(*torques: Torque, noise: float = 0.05, joints: int = 1) -> SplitData:
    def extra(motion: Motion) -> Floats:
        return sum((torque(motion) for torque in torques), np.zeros_like(motion.position))

    return building.split([building.record(joints, noise=noise, extra=extra)])


def selector(data: SplitData, effects: Mapping[str, Effect] = USUAL) -> tuple[Search, Any]:
    model = building.structure(data.recordings[0].recording)
    return Search(data, effects, lambda text: None), (model, building.start(model))


def select(data: SplitData, effects: Mapping[str, Effect] = USUAL) -> Selection:
    chosen, begin = selector(data, effects)
    return chosen.select(*begin)


def added(selection: Selection) -> list[str | None]:
    return [step.added for step in selection.steps]


def final(selection: Selection) -> set[str]:
    return {term.name for term in selection.steps[-1].model.terms}


def test_nothing_is_added_to_a_correct_model() -> None:
    selection = select(split())
    assert added(selection) == [None]
    assert selection.findings == ()


@pytest.mark.parametrize(
    ("torques", "names"),
    [
        ((drag,), ["quadratic_friction"]),
        ((drag, offset), ["quadratic_friction", "torque_offset"]),
        ((offset, drag, spring), ["joint_spring", "quadratic_friction"]),
    ],
)
def test_planted_effects_are_added_the_largest_first(torques: tuple[Torque, ...], names: list[str]) -> None:
    selection = select(split(*torques))
    assert added(selection) == [None, *names]
    assert [finding.term.name for finding in selection.findings] == names
    assert all(finding.improvement.share > 0.9 and finding.alternatives == () for finding in selection.findings)


def test_parameters_are_those_that_were_planted() -> None:
    solution = select(split(drag, noise=0.02)).steps[-1].model.solution
    np.testing.assert_allclose(solution.x, [*building.parameters(), 0.3], rtol=0.02)


def test_effect_is_added_to_the_joint_that_has_it() -> None:
    selection = select(split(lambda motion: spring(motion) * [0.0, 1.0], joints=2))
    (finding,) = selection.findings
    assert (finding.term.name, finding.term.joints) == ("joint_spring", (1,))


def test_effect_that_imitates_two_others_is_replaced_by_them() -> None:
    """Alone it explains most, but neither of them improves it."""
    effects = {"quadratic_friction": USUAL["quadratic_friction"], "joint_spring": USUAL["joint_spring"]}
    assert final(select(split(drag, spring), {**effects, "imitation": building.effect(imitation)})) == set(effects)


def test_imitation_is_kept_if_it_is_the_truth() -> None:
    effects = {**USUAL, "sum": building.effect(imitation)}
    assert final(select(split(imitation), effects)) == {"sum"}


@pytest.mark.parametrize("reach", [3.0, 2.0])
def test_effect_supported_only_beside_another_is_tried_if_both_explain_much(reach: float) -> None:
    """The wave acts beyond 1 rad only, and the other motion hardly goes there: alone it makes that worse.

    With a smaller reach, the wave alone explains little of the training data, too.
    """

    def wave(motion: Motion) -> Floats:
        return np.cos(4 * motion.position)

    def correction(motion: Motion) -> Floats:
        inside = np.abs(motion.position) < 1
        return np.where(inside, -np.cos(4 * motion.position), 0.4 * np.sin(4 * motion.position))

    def true(motion: Motion) -> Floats:
        return wave(motion) + correction(motion)

    train = building.record(noise=0.05, extra=true, size=reach)
    data = building.split([train], [building.record(noise=0.05, extra=true, size=0.7, shape=1, name="b")])
    effects = {"wave": building.effect(wave), "correction": building.effect(correction)}
    assert final(select(data, effects)) == set(effects)
    for name in effects:
        assert final(select(data, {name: effects[name]})) == set()


def test_two_effects_of_a_joint_that_hide_each_other_are_found_if_other_joints_show_one_of_them() -> None:
    """On the second joint, the sum of both has little in common with either."""

    def second(motion: Motion) -> Floats:
        return -0.8 * drag(motion) + 1.2 * ripple(motion)

    data = split(lambda motion: drag(motion) + second(motion) * [0.0, 1.0], joints=2)
    selection = select(data, {"drag": building.effect(drag), "second": building.effect(second)})
    assert {(term.name, term.joints) for term in selection.model.terms} == {("drag", (0, 1)), ("second", (1,))}


def test_two_effects_that_nearly_cancel_are_found_together() -> None:
    def opposite(motion: Motion) -> Floats:
        return -ripple(motion) + 0.1 * np.sin(9 * motion.position)

    effects = {**USUAL, "ripple": building.effect(ripple), "opposite": building.effect(opposite)}
    data = split(lambda motion: 3 * ripple(motion) + 3 * opposite(motion), noise=0.02)
    assert final(select(data, effects)) == {"ripple", "opposite"}


def test_power_law_is_found_beside_quadratic_friction_which_it_contains() -> None:
    def root(motion: Motion) -> Floats:
        return np.sqrt(np.abs(motion.velocity)) * motion.direction

    effects = {name: LIBRARY[name] for name in ("quadratic_friction", "power_law_friction")}
    assert final(select(split(drag, root, noise=0.02), effects)) == set(effects)


@pytest.mark.parametrize(("size", "names"), [(0.0, {"quadratic_friction"}), (1.0, set())])
def test_minor_effect_is_not_added_while_a_large_error_remains(size: float, names: set[str]) -> None:
    """Drag of a fifteenth of its size, beside a ripple that no effect explains."""
    data = split(lambda motion: drag(motion) / 15, lambda motion: size * ripple(motion), noise=0.02)
    assert final(select(data, {"quadratic_friction": USUAL["quadratic_friction"]})) == names


def test_effect_that_a_later_one_contains_is_removed() -> None:
    """An offset explains most at first; a spring with a rest angle contains it."""
    selection = select(split(lambda motion: 2.0 + 0.5 * motion.position))
    assert final(selection) == {"joint_spring"}


def test_effects_that_this_motion_cannot_tell_apart_are_alternatives() -> None:
    """Both columns are the same but for a thousandth."""
    twin = building.effect(lambda motion: drag(motion) * (1 + 1e-3 * np.cos(motion.position)))
    effects = {"drag": building.effect(drag), "twin": twin}
    (finding,) = select(split(drag), effects).findings
    assert {finding.term.name, *finding.alternatives} == {"drag", "twin"}


def test_clear_difference_leaves_no_alternative() -> None:
    other = building.effect(lambda motion: drag(motion) * (1 + 0.3 * np.cos(motion.position)))
    (finding,) = select(split(drag), {"drag": building.effect(drag), "other": other}).findings
    assert (finding.term.name, finding.alternatives) == ("drag", ())


def test_training_rows_decide_if_the_test_rows_cannot() -> None:
    """The columns differ beyond 1 rad, where only the training motion goes."""

    def weaker(motion: Motion) -> Floats:
        return drag(motion) * np.where(np.abs(motion.position) > 1, 0.6, 1.0)

    data = building.split(
        [building.record(noise=0.05, extra=drag, size=1.3)],
        [building.record(noise=0.05, extra=drag, size=0.5, shape=1, name="b")],
    )
    effects = {"weaker": building.effect(weaker), "drag": building.effect(drag)}
    (finding,) = select(data, effects).findings
    assert (finding.term.name, finding.alternatives) == ("drag", ())


def test_mandatory_effect_is_always_in_the_model_and_never_an_extension() -> None:
    effects = {"drag": building.effect(drag, mandatory=True), **USUAL}
    selection = select(split(spring), effects)
    assert added(selection) == [None, "drag", "joint_spring"]
    assert [term.name for term in selection.steps[0].model.terms] == []
    assert final(selection) == {"drag", "joint_spring"}
    assert added(select(split(drag), {"drag": effects["drag"]})) == [None, "drag"]


def test_forced_effects_are_added_in_their_order_and_no_others() -> None:
    chosen, begin = selector(split(drag, spring))
    selection = chosen.select_forced(*begin, ["torque_offset", "quadratic_friction"])
    assert added(selection) == [None, "torque_offset", "quadratic_friction"]
    assert [finding.term.name for finding in selection.findings] == ["torque_offset", "quadratic_friction"]


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (["quadratic_friction", "quadratic_friction"], "is in the model already"),
        (["viscous"], "does not show in this motion"),
    ],
)
def test_forced_effect_that_shows_nothing_is_refused(names: list[str], reason: str) -> None:
    effects = {**USUAL, "viscous": building.effect(lambda motion: motion.velocity)}
    chosen, begin = selector(split(drag), effects)
    with pytest.raises(BadInput, match=f"'{names[-1]}' {reason}"):
        chosen.select_forced(*begin, names)


def test_forced_effect_of_an_impossible_sign_explains_nothing() -> None:
    chosen, begin = selector(split(lambda motion: -drag(motion)))
    (finding,) = chosen.select_forced(*begin, ["quadratic_friction"]).findings
    assert (finding.judgement.accepted, finding.judgement.evidence.gain) == (False, 0.0)


def test_selection_without_an_effect_has_the_findings_of_the_others() -> None:
    chosen, begin = selector(split(drag, offset))
    selection = chosen.select(*begin)
    other = chosen.without(selection, "torque_offset", "of a test")
    assert added(other) == [None, "quadratic_friction"]
    assert [finding.term.name for finding in other.findings] == ["quadratic_friction"]
    assert other.rejected["torque_offset"].why.endswith("of a test.")


def test_computed_torque_and_residual_add_up_to_the_measured_one() -> None:
    data = split(drag)
    selection = select(data)
    for dataset, computed, residual in zip(
        data.recordings, selection.model.computed, selection.model.residuals, strict=True
    ):
        np.testing.assert_allclose(computed + residual, dataset.torque)
