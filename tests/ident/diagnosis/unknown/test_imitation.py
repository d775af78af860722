"""Effects that only imitate an unknown one are left out."""

import numpy as np
import pytest

from ident.diagnosis.search.selection import Selection
from ident.diagnosis.unknown import imitation
from ident.diagnosis.unknown.imitation import analyse_unexplained
from ident.diagnosis.unknown.residual_dependence import NonparametricFit
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.recording import Floats
from tests.ident import building
from tests.ident.building import drag


def concave(motion: Motion) -> Floats:
    """Friction that rises ever less: no effect of these tests."""
    torque: Floats = 1.5 * np.sqrt(np.abs(motion.velocity)) * motion.direction
    return torque


def cable(motion: Motion) -> Floats:
    """A cable that the other joint pulls."""
    return 2.0 * np.sin(motion.position[:, ::-1] + 0.5)


def both(motion: Motion) -> Floats:
    """An effect of these tests beside an unknown one of another variable."""
    return concave(motion) + 2 * motion.position


EFFECTS = {
    "drag": building.effect(drag),
    "cubic": building.effect(lambda motion: motion.velocity**3),
    "spring": building.effect(lambda motion: motion.position),
}


def checked(
    torque: building.Torque, added: list[str], joints: int = 1, forced: bool = False
) -> tuple[Selection, NonparametricFit | None, Selection]:
    """The selection of the effects `added` before the check, the curves that replace effects, and that after it."""
    data = building.split([building.record(joints, noise=0.02, extra=torque)])
    search, begin = building.search(data, {name: EFFECTS[name] for name in added})
    selection = search.select_forced(*begin, added)
    result, _, curves = analyse_unexplained(search, selection, forced)
    return selection, curves, result


@pytest.mark.parametrize(
    ("torque", "added", "forced"),
    [
        (drag, ["drag"], False),  # the truth
        (concave, [], False),
        (concave, ["drag"], True),  # as requested
        (both, ["spring"], False),
    ],
)
def test_what_is_no_imitation_is_kept(torque: building.Torque, added: list[str], forced: bool) -> None:
    selection, _, result = checked(torque, added, forced=forced)
    assert result is selection


@pytest.mark.parametrize(
    ("torque", "added", "joints", "curve", "why"),
    [
        (concave, ["drag", "cubic"], 1, ("velocity",), "curves over velocity leave nothing of it to explain."),
        # The joints move together.
        (cable, ["spring"], 2, ("position", "joint_1"), "negligible beside what else is missing."),
    ],
)
def test_effects_that_only_imitate_an_unknown_one_are_left_out(
    torque: building.Torque, added: list[str], joints: int, curve: tuple[str, ...], why: str
) -> None:
    """Beside a curve, none of them explains anything."""
    selection, curves, result = checked(torque, added, joints)
    assert [step.added for step in selection.steps] == [None, *added]
    assert [step.added for step in result.steps] == [None]
    assert result.rejected[added[0]].why.endswith(why)
    assert curves is not None
    assert curves.improvement.is_supported
    assert curve in {each.variables for each in curves.dependences}


def test_curves_that_are_the_worse_model_in_its_place_refute_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(imitation, "likelihood_score", lambda model, _: len(model.solution.x))
    selection, _, result = checked(concave, ["drag", "cubic"])
    assert result is selection


def test_curve_over_speed_is_judged_within_the_speeds_of_training() -> None:
    recordings = [building.record(noise=0.02, extra=concave, size=size, name=str(size)) for size in (1.0, 1.5)]
    search, begin = building.search(building.split(recordings[:1], recordings[1:]), {"drag": EFFECTS["drag"]})
    result, _, _ = analyse_unexplained(search, search.select_forced(*begin, ["drag"]), forced=False)
    assert not result.findings


def test_mandatory_effect_is_never_removed() -> None:
    """That a curve explains more beside it is no reason against it."""
    data = building.split([building.record(noise=0.02, extra=lambda motion: 3 * drag(motion) + concave(motion))])
    search, begin = building.search(data, {"drag": building.effect(drag, mandatory=True)})
    result, _, _ = analyse_unexplained(search, search.select_forced(*begin, ()), forced=False)
    assert {term.name for term in result.steps[-1].model.terms} == {"drag"}


def test_effects_of_a_given_model_are_kept() -> None:
    data = building.split([building.record(noise=0.02, extra=concave)])
    search, (bare, _) = building.search(data, {"drag": EFFECTS["drag"]})
    given = bare.with_term(Term("drag", EFFECTS["drag"], (0,)))
    selection = search.select_forced(given, building.start(given), ())
    assert analyse_unexplained(search, selection, forced=False)[0].steps[0].model.terms == given.terms
