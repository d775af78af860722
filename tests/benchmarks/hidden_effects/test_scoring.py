"""The rules by which what was said is compared with what was hidden."""

from typing import Any

import pytest

from benchmarks.hidden_effects.cases import Case, Kind
from benchmarks.hidden_effects.scoring import Judgement, judge

TRUTH = {
    "stribeck": {
        "name": "stribeck",
        "joints": [1, 2],
        "parameters": {"a": 1.0, "v_s": 0.3},
        "depends_on": ["velocity"],
    },
    "cogging": {"name": "cogging", "joints": [1], "parameters": {"a": 0.5}, "depends_on": ["position"]},
    "hose_drag": {
        "name": "hose_drag",
        "joints": [1, 2],
        "parameters": {},
        "depends_on": ["velocity", "joint_1", "joint_2"],
    },
}


def said(
    kind: Kind,
    hidden: tuple[str, ...],
    verdict: str,
    findings: dict[str, list[str]],
    variables: tuple[str, ...] = (),
    parameters: dict[str, float] | None = None,
    cautions: tuple[str, ...] = (),
) -> Judgement:
    """`findings`: effect to what it may be confused with."""
    case = Case("foreign", kind, hidden, (0.03,) * len(hidden), "default", 1)
    document: dict[str, Any] = {
        "verdict": verdict,
        "noise_rms": [0.3, 0.4, 0.0],
        "findings": [
            {"effect": name, "confusable_with": others, "joints": [1, 2]} for name, others in findings.items()
        ],
        "rungs": [
            {
                "validate_rms": [0.6, 0.8, 0.0],
                "parameters": {
                    name: {"value": value, "ci95": (value - 0.2, value + 0.2)}
                    for name, value in (parameters or {}).items()
                },
            }
        ],
        "remaining": {"depends_on": list(variables)},
        "cautions": cautions,
    }
    return judge(case, {"effects": [TRUTH[name] for name in hidden]}, {"document": document, "seconds": 1.0})


@pytest.mark.parametrize(
    ("findings", "right"),
    [
        ({"stribeck": []}, True),
        ({"rod_inertia": [], "stribeck": []}, True),
        ({"presliding_hysteresis": ["stribeck"]}, True),
        ({"presliding_hysteresis": ["a", "b", "c", "stribeck"]}, False),
        ({"cogging": [], "stribeck": []}, False),
        ({"rod_inertia": []}, False),
    ],
)
def test_a_single_effect_has_to_be_named_first_or_in_a_group_of_four(
    findings: dict[str, list[str]], right: bool
) -> None:
    assert said("single", ("stribeck",), "missing-effect", findings).right is right


@pytest.mark.parametrize(
    ("findings", "right"),
    [
        ({"stribeck": [], "cogging": []}, True),
        ({"cogging": [], "air_drag": ["stribeck"]}, True),
        ({"cogging": [], "air_drag": [], "stribeck": []}, True),
        ({"cogging": [], "air_drag": [], "base_tilt": [], "stribeck": []}, False),
        ({"cogging": ["stribeck"]}, False),
    ],
)
def test_of_a_pair_both_have_to_be_named_by_findings_of_their_own(
    findings: dict[str, list[str]], right: bool
) -> None:
    assert said("pair", ("stribeck", "cogging"), "missing-effect", findings).right is right


def test_an_exact_name_does_not_take_the_group_that_another_effect_needs() -> None:
    judged = said(
        "pair", ("stribeck", "cogging"), "missing-effect", {"stribeck": ["cogging"], "air_drag": ["stribeck"]}
    )
    assert (judged.found, judged.extra) == (2, 0)


def test_with_nothing_hidden_only_adequate_is_right() -> None:
    assert said("nothing", (), "adequate", {"rod_inertia": []}).right
    assert not said("nothing", (), "unknown-structure", {}).right


@pytest.mark.parametrize(
    ("verdict", "variables", "right"),
    [
        ("unknown-structure", ("velocity", "joint_1", "joint_2"), True),
        ("unknown-structure", ("velocity", "joint_1", "joint_2", "position"), True),
        ("unknown-structure", ("velocity", "joint_1", "joint_2", "position", "time"), False),
        ("unknown-structure", ("velocity", "joint_1"), False),
        ("missing-effect", ("velocity", "joint_1", "joint_2"), False),
    ],
)
def test_outside_the_library_all_variables_and_hardly_another_one(
    verdict: str, variables: tuple[str, ...], right: bool
) -> None:
    assert said("outside", ("hose_drag",), verdict, {}, variables).right is right


def test_the_held_out_error_is_compared_with_the_floor_over_all_joints() -> None:
    assert said("nothing", (), "adequate", {}).over_floor == pytest.approx(2.0)


def test_whether_the_motion_is_said_to_go_beyond_the_training() -> None:
    caution = "Joint 1: 90% of ... is where the torque of joint 1 is outside of the 0 to 2 N m that the fit has seen."
    assert said("nothing", (), "adequate", {}, cautions=("Too short to tell", caution)).beyond
    assert not said("nothing", (), "adequate", {}, cautions=("Too short to tell",)).beyond


def test_the_error_of_a_strength_is_the_mean_over_its_joints() -> None:
    parameters = {"stribeck.a1": 1.1, "stribeck.a2": 0.7, "stribeck.v_s": 0.3}
    judged = said("single", ("stribeck",), "missing-effect", {"stribeck": []}, parameters=parameters)
    assert judged.errors == {"stribeck": pytest.approx(0.2)}
    amplitude = {"cogging.a1": 0.3, "cogging.b1": 0.4, "cogging.N": 21.0}
    judged = said("single", ("cogging",), "missing-effect", {"cogging": []}, parameters=amplitude)
    assert judged.errors == {"cogging": pytest.approx(0.0)}


def test_an_interval_holds_the_truth_or_not_on_each_joint() -> None:
    parameters = {"stribeck.a1": 1.1, "stribeck.a2": 0.7, "stribeck.v_s": 0.3}
    judged = said("single", ("stribeck",), "missing-effect", {"stribeck": []}, parameters=parameters)
    assert judged.inside == (True, False)
    assert said("single", ("stribeck",), "missing-effect", {"cogging": []}).inside == ()


def test_a_diagnosis_that_fails_is_never_right() -> None:
    case = Case("foreign", "nothing", (), (), "default", 1)
    judged = judge(case, {"effects": []}, {"error": "ValueError: no", "seconds": 0.1})
    assert not judged.right
    assert judged.problem == "ValueError: no"
