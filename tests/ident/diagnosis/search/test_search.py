"""Stepwise selection on recordings of a few axes with planted effects."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pytest

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.best_first import BestFirst
from ident.diagnosis.search.candidates import Fits, Key, key_of
from ident.diagnosis.search.selection import Selection
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect, Quantity
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.errors import BadInput
from recordings.recording import Floats
from tests.ident import building
from tests.ident.building import drag

LIBRARY = library()
USUAL = {name: LIBRARY[name] for name in ("torque_offset", "quadratic_friction", "joint_spring", "stribeck")}


def spring(motion: Motion) -> Floats:
    return 1.2 * motion.position


def offset(motion: Motion) -> Floats:
    return np.full_like(motion.position, 0.4)


def ripple(motion: Motion) -> Floats:
    """A torque that no effect of the library explains."""
    return np.cos(4 * motion.position)


def opposite(motion: Motion) -> Floats:
    """Nearly the opposite of the ripple."""
    return -ripple(motion) + 0.1 * np.sin(9 * motion.position)


def imitation(motion: Motion) -> Floats:
    """Drag and spring with a ripple."""
    return drag(motion) + spring(motion) + 0.5 * ripple(motion)


def hiding(motion: Motion) -> Floats:
    """A torque whose sum with the drag has little in common with either."""
    return -0.8 * drag(motion) + 1.2 * ripple(motion)


def falling(motion: Motion) -> Floats:
    """Friction that falls with speed."""
    torque: Floats = 1.5 * np.exp(-((motion.velocity / 0.3) ** 2)) * motion.direction
    return torque


def root(motion: Motion) -> Floats:
    torque: Floats = np.sqrt(np.abs(motion.velocity)) * motion.direction
    return torque


def split(torque: building.Torque, noise: float = 0.05, joints: int = 1) -> SplitData:
    return building.split([building.record(joints, noise=noise, extra=torque)])


def select(data: SplitData, effects: Mapping[str, Effect] = USUAL) -> Selection:
    search, begin = building.search(data, effects)
    return search.select(*begin)


def added(selection: Selection) -> list[str | None]:
    return [step.added for step in selection.steps]


def found(selection: Selection) -> dict[str, tuple[int, ...]]:
    """The effects of the last model and their joints."""
    return {term.name: term.joints for term in selection.steps[-1].model.terms}


@dataclass(frozen=True)
class Planted:
    """A torque that the mechanism lacks, the effects that are tried, and those that must be left, with joints."""

    torque: building.Torque
    effects: Mapping[str, Effect]
    found: dict[str, tuple[int, ...]]
    noise: float = 0.05
    joints: int = 1


ONE = (0,)
DRAG = {"quadratic_friction": USUAL["quadratic_friction"]}
PARTS = {**DRAG, "joint_spring": USUAL["joint_spring"]}
POWERS = {**DRAG, "power_law_friction": LIBRARY["power_law_friction"]}
CANCELLING = {"ripple": building.effect(ripple), "opposite": building.effect(opposite)}
EACH_WAY = building.effect(
    drag,
    parameters=tuple(Quantity(name=name, unit="{effort}", meaning="", lower=0.0) for name in ("forward", "back")),
    columns=lambda inputs, _: np.stack(
        [drag(inputs.motion) * (sign * inputs.motion.velocity > 0) for sign in (1, -1)], axis=2
    ),
)
PLANTED = {
    "nothing is added to a correct model": Planted(lambda motion: 0 * motion.position, USUAL, {}),
    "only the joint that has it": Planted(
        lambda motion: spring(motion) * [0.0, 1.0], USUAL, {"joint_spring": (1,)}, joints=2
    ),
    "what imitates two others is replaced by them": Planted(
        lambda motion: drag(motion) + spring(motion),
        {**PARTS, "imitation": building.effect(imitation)},
        dict.fromkeys(PARTS, ONE),
    ),
    "the same is kept where it is the truth": Planted(
        imitation, {**USUAL, "sum": building.effect(imitation)}, {"sum": ONE}
    ),
    "another joint shows one of two that hide each other": Planted(
        lambda motion: drag(motion) + hiding(motion) * [0.0, 1.0],
        {"drag": building.effect(drag), "hiding": building.effect(hiding)},
        {"drag": (0, 1), "hiding": (1,)},
        joints=2,
    ),
    "two that nearly cancel": Planted(
        lambda motion: 3 * ripple(motion) + 3 * opposite(motion),
        {**USUAL, **CANCELLING},
        dict.fromkeys(CANCELLING, ONE),
        noise=0.02,
    ),
    "a power law beside the quadratic friction that it contains": Planted(
        lambda motion: drag(motion) + root(motion), POWERS, dict.fromkeys(POWERS, ONE), noise=0.02
    ),
    "of two coefficients with a limit one is zero": Planted(
        lambda motion: drag(motion) * (motion.velocity > 0), {"each way": EACH_WAY}, {"each way": (0, 1, 2)}, joints=3
    ),
    "of two coefficients with a limit one would be far beyond it": Planted(
        lambda motion: np.abs(drag(motion)), {"each way": EACH_WAY}, {}
    ),
    "a minor effect alone": Planted(lambda motion: drag(motion) / 15, DRAG, {"quadratic_friction": ONE}, noise=0.02),
    "a minor effect beside a large error": Planted(
        lambda motion: drag(motion) / 15 + ripple(motion), DRAG, {}, noise=0.02
    ),
    "two joints of seven": Planted(
        lambda motion: drag(motion) * np.isin(np.arange(7), (1, 4)), USUAL, {"quadratic_friction": (1, 4)}, joints=7
    ),
    "not where it takes little of what else is missing": Planted(
        lambda motion: drag(motion) * [1.0, 1 / 15] + ripple(motion) * [0.0, 1.0],
        DRAG,
        {"quadratic_friction": ONE},
        noise=0.02,
        joints=2,
    ),
    "a law of friction, but not where the rest of the friction would drive": Planted(
        lambda motion: falling(motion) - [0.0, 2.5] * motion.direction,
        {"stribeck": USUAL["stribeck"]},
        {"stribeck": ONE},
        joints=2,
    ),
    "an offset is removed after the spring that contains it": Planted(
        lambda motion: 2.0 + 0.5 * motion.position, USUAL, {"joint_spring": ONE}
    ),
}


@pytest.mark.parametrize("case", PLANTED.values(), ids=PLANTED)
def test_only_what_was_planted_is_left(case: Planted) -> None:
    selection = select(split(case.torque, case.noise, case.joints), case.effects)
    named = {finding.term.name: finding.term.joints for finding in selection.findings}
    assert found(selection) == named == case.found


@pytest.mark.parametrize(
    ("torques", "names"),
    [
        ((drag,), ["quadratic_friction"]),
        ((drag, offset), ["quadratic_friction", "torque_offset"]),
        ((offset, drag, spring), ["joint_spring", "quadratic_friction"]),  # a spring has a rest angle
    ],
)
def test_planted_effects_are_added_the_largest_first(torques: tuple[building.Torque, ...], names: list[str]) -> None:
    selection = select(split(lambda motion: np.sum([torque(motion) for torque in torques], axis=0)))
    assert added(selection) == [None, *names]
    assert [finding.term.name for finding in selection.findings] == names
    assert all(finding.improvement.share > 0.9 and finding.alternatives == () for finding in selection.findings)


@pytest.mark.parametrize("reach", [3.0, 2.0])
def test_effect_supported_only_beside_another_is_tried_if_both_explain_much(reach: float) -> None:
    """The wave acts beyond 1 rad only, and the other motion hardly goes there: alone it makes that worse.

    With a smaller reach, the wave alone explains little of the training data, too.
    """

    def correction(motion: Motion) -> Floats:
        inside = np.abs(motion.position) < 1
        return np.where(inside, -ripple(motion), 0.4 * np.sin(4 * motion.position))

    def true(motion: Motion) -> Floats:
        return ripple(motion) + correction(motion)

    train = building.record(noise=0.05, extra=true, size=reach)
    data = building.split([train], [building.record(noise=0.05, extra=true, size=0.7, shape=1, name="b")])
    effects = {"wave": building.effect(ripple), "correction": building.effect(correction)}
    assert found(select(data, effects)).keys() == effects.keys()
    for name in effects:
        assert found(select(data, {name: effects[name]})) == {}


@pytest.mark.parametrize(("difference", "alike"), [(1e-3, True), (0.3, False)])
def test_effects_that_this_motion_cannot_tell_apart_are_alternatives(difference: float, alike: bool) -> None:
    other = building.effect(lambda motion: drag(motion) * (1 + difference * np.cos(motion.position)))
    (finding,) = select(split(drag), {"drag": building.effect(drag), "other": other}).findings
    assert {finding.term.name, *finding.alternatives} == ({"drag", "other"} if alike else {"drag"})


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
    assert selection.steps[0].model.terms == ()
    assert added(select(split(drag), {"drag": effects["drag"]})) == [None, "drag"]


def test_forced_effects_are_added_in_their_order_and_no_others() -> None:
    search, begin = building.search(split(lambda motion: spring(motion) - drag(motion)), USUAL)
    names = ["torque_offset", "quadratic_friction"]
    selection = search.select_forced(*begin, names)
    assert added(selection) == [None, *names]
    assert [finding.term.name for finding in selection.findings] == names
    impossible = selection.findings[1].judgement  # friction that drives the motion
    assert (impossible.accepted, impossible.evidence.gain) == (False, 0.0)


@pytest.mark.parametrize(
    ("names", "reason"),
    [
        (["quadratic_friction", "quadratic_friction"], "is in the model already"),
        (["viscous"], "does not show in this motion"),
    ],
)
def test_forced_effect_that_shows_nothing_is_refused(names: list[str], reason: str) -> None:
    effects = {**USUAL, "viscous": building.effect(lambda motion: motion.velocity)}
    search, begin = building.search(split(drag), effects)
    with pytest.raises(BadInput, match=f"'{names[-1]}' {reason}"):
        search.select_forced(*begin, names)


def test_selection_without_an_effect_has_the_findings_of_the_others() -> None:
    search, begin = building.search(split(lambda motion: drag(motion) + offset(motion)), USUAL)
    other = search.without(search.select(*begin), "torque_offset", "of a test")
    assert added(other) == [None, "quadratic_friction"]
    assert [finding.term.name for finding in other.findings] == ["quadratic_friction"]
    assert other.rejected["torque_offset"].why.endswith("of a test.")


@pytest.mark.parametrize(
    ("torque", "noise", "rule"),
    [
        (lambda motion: drag(motion) / 15 + ripple(motion), 0.05, "size"),
        (drag, 0.2, "screening"),
    ],
)
def test_rejected_effects_have_the_evidence_that_they_have_when_they_are_asked_for(
    torque: building.Torque, noise: float, rule: str
) -> None:
    data, rules = split(torque, noise), set[str]()
    selection = select(data)
    last = selection.model.solution
    for name, rejection in selection.rejected.items():
        search, _ = building.search(data, USUAL)
        findings = search.select_forced(last.structure, last.x, [name]).findings
        asked = next(each.judgement.evidence for each in findings if each.term.name == name)
        stated = rejection.evidence
        assert stated is not None
        rules.add(stated.decided_by)
        if stated.decided_by == "screening":
            assert asked.gain <= stated.gain + 0.01
        else:
            assert asked.decided_by == stated.decided_by
            for field in ("gain", "gain_ci95", "t", "power"):
                assert getattr(asked, field) == pytest.approx(getattr(stated, field), abs=1e-3)
    assert rule in rules


def test_effect_keeps_its_joints_where_another_is_added_to_a_known_model(monkeypatch: pytest.MonkeyPatch) -> None:
    """The fit that is known may have its effects in another order."""
    known: dict[Key, FittedModel] = {}
    monkeypatch.setattr(
        Fits, "best", lambda _, model: known.setdefault(key_of(model.solution.structure, model.solution.x), model)
    )
    search, begin = building.search(split(lambda motion: drag(motion) * [1.0, 0.0] + spring(motion), joints=2), PARTS)
    model, _ = search.start(*begin)
    for names in (("quadratic_friction", "joint_spring"), ("joint_spring", "quadratic_friction")):
        both = search.add(search.add(model, names[0]), names[1])
        assert {term.name: term.joints for term in both.terms} == {"joint_spring": (0, 1), "quadratic_friction": (0,)}


def test_what_is_better_but_seldom_is_named_beside_what_is_likely() -> None:
    """A spring over five turns, which no machine has, leaves a third of what the offset does."""
    recording = building.record(noise=0.1, extra=lambda motion: 0.3 + 0.01 * motion.position, drift=2.0)
    effects = {name: library()[name] for name in ("torque_offset", "joint_spring")}
    search, begin = building.search(building.split([recording]), effects)
    (finding,) = search.select(*begin).findings
    assert (finding.term.name, finding.alternatives) == ("torque_offset", ("joint_spring",))


def test_what_an_effect_contains_takes_its_joint_as_well() -> None:
    effects = {"drag": building.effect(drag), "each way": EACH_WAY.changed(contains=("drag",))}
    search, (structure, _) = building.search(split(drag, joints=2), effects)
    for joint, (name, effect) in enumerate(effects.items()):
        structure = structure.with_term(Term(name, effect, (joint,)))
    model = search.fits.fit(structure, np.zeros(len(structure.parameters)))
    (term,) = BestFirst(search.candidates, lambda text: None).search(model).terms
    assert (term.name, term.joints) == ("drag", (0, 1))


def test_each_line_of_a_spectrum_has_the_evidence_of_its_own_removal() -> None:
    def lines(motion: Motion) -> Floats:
        return np.sin(9 * motion.position) + 0.3 * np.sin(23 * motion.position)

    selection = select(split(lines), {"cogging": LIBRARY["cogging"]})
    large, small = selection.findings
    for kept, finding in ((23, large), (9, small)):
        structure, x = finding.before.solution.structure, finding.before.solution.x
        assert structure.shape_values(0, x) == pytest.approx(kept, rel=0.1)
