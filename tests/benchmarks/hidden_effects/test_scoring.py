"""Acceptance rules that compare diagnoses with hidden effects."""

from typing import Any

import pytest

from benchmarks.hidden_effects import strengths
from benchmarks.hidden_effects.cases import HiddenCase, Kind
from benchmarks.hidden_effects.scoring import ScoredCase, judge

TRUTH = {
    "stribeck": {
        "name": "stribeck",
        "joints": [1, 2],
        "size": 0.03,
        "parameters": {"a": 1.0, "v_s": 0.3},
        "depends_on": ["velocity"],
    },
    "cogging": {
        "name": "cogging",
        "joints": [1],
        "size": 0.03,
        "parameters": {"a": 0.5},
        "depends_on": ["position"],
    },
    "hose_drag": {
        "name": "hose_drag",
        "joints": [1, 2],
        "size": 0.03,
        "parameters": {},
        "depends_on": ["velocity", "joint_1", "joint_2"],
    },
}


def judgement_of(
    kind: Kind,
    hidden: tuple[str, ...],
    verdict: str,
    findings: dict[str, list[str]],
    variables: tuple[str, ...] = (),
    parameters: dict[str, float] | None = None,
    warnings: tuple[str, ...] = (),
    floor: tuple[float | None, ...] = (0.3, 0.4, 0.0),
) -> ScoredCase:
    """ScoredCase of a diagnosis; `findings` maps each effect to those that it is confusable with."""
    case = HiddenCase("foreign", kind, hidden, (0.03,) * len(hidden), "default", 1)
    document: dict[str, Any] = {
        "verdict": verdict,
        "noise_rms": list(floor),
        "findings": [
            {"effect": name, "confusable_with": others, "joints": [1, 2]} for name, others in findings.items()
        ],
        "steps": [
            {
                "held_out_rms": [0.6, 0.8, 0.0],
                "parameters": {
                    name: {"value": value, "ci95": (value - 0.2, value + 0.2)}
                    for name, value in (parameters or {}).items()
                },
            }
        ],
        "remaining": {"depends_on": list(variables)},
        "warnings": warnings,
    }
    return judge(case, {"effects": [TRUTH[name] for name in hidden]}, {"document": document, "seconds": 1.0})


@pytest.mark.parametrize(
    ("kind", "verdict", "findings", "right"),
    [
        # A single effect is named first, or in a group of four; the inertia of the rods does not count.
        ("single", "missing-effect", {"stribeck": []}, True),
        ("single", "missing-effect", {"rod_inertia": [], "stribeck": []}, True),
        ("single", "missing-effect", {"presliding_hysteresis": ["stribeck"]}, True),
        ("single", "missing-effect", {"presliding_hysteresis": ["a", "b", "c", "stribeck"]}, False),
        ("single", "missing-effect", {"cogging": [], "stribeck": []}, False),
        ("single", "missing-effect", {"rod_inertia": []}, False),
        # Both effects of a pair are named by different findings, with at most one more.
        ("pair", "missing-effect", {"stribeck": [], "cogging": []}, True),
        ("pair", "missing-effect", {"cogging": [], "air_drag": ["stribeck"]}, True),
        ("pair", "missing-effect", {"cogging": [], "air_drag": [], "stribeck": []}, True),
        ("pair", "missing-effect", {"cogging": [], "air_drag": [], "base_tilt": [], "stribeck": []}, False),
        ("pair", "missing-effect", {"cogging": ["stribeck"]}, False),
        ("pair", "missing-effect", {"stribeck": ["cogging"], "air_drag": ["stribeck"]}, True),
        ("nothing", "adequate", {"rod_inertia": []}, True),
        ("nothing", "adequate", {"stribeck": []}, False),
        ("nothing", "undetermined", {}, False),
        ("nothing", "unknown-structure", {}, False),
    ],
)
def test_what_is_right(kind: Kind, verdict: str, findings: dict[str, list[str]], right: bool) -> None:
    hidden = {"single": ("stribeck",), "pair": ("stribeck", "cogging")}.get(kind, ())
    assert judgement_of(kind, hidden, verdict, findings).right is right


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
def test_out_of_library_effect_requires_all_its_variables_and_at_most_one_other(
    verdict: str, variables: tuple[str, ...], right: bool
) -> None:
    assert judgement_of("outside", ("hose_drag",), verdict, {}, variables).right is right


def test_false_name_is_one_of_whose_group_no_effect_is_hidden() -> None:
    judgement = judgement_of("single", ("stribeck",), "missing-effect", {"stribeck": [], "cogging": []})
    assert [judgement.is_hidden(finding) for finding in judgement.findings] == [True, False]


def test_held_out_error_is_compared_with_the_noise_floor_over_all_joints() -> None:
    assert judgement_of("nothing", (), "adequate", {}).over_floor == pytest.approx(2.0)


def test_warning_about_extrapolation_is_recognized() -> None:
    warning = "Joint 1: 90% of ... is where the torque of joint 1 is outside of the 0 to 2 N m of the training data."
    assert judgement_of("nothing", (), "adequate", {}, warnings=("Too short to tell", warning)).extrapolates
    assert not judgement_of("nothing", (), "adequate", {}, warnings=("Too short to tell",)).extrapolates


def test_error_of_a_strength_is_the_mean_over_its_joints() -> None:
    parameters = {"stribeck.a1": 1.1, "stribeck.a2": 0.7, "stribeck.v_s": 0.3}
    judged = judgement_of("single", ("stribeck",), "missing-effect", {"stribeck": []}, parameters=parameters)
    assert judged.errors == {"stribeck": pytest.approx(0.2)}
    amplitude = {"cogging.a1": 0.3, "cogging.b1": 0.4, "cogging.N": 21.0}
    judged = judgement_of("single", ("cogging",), "missing-effect", {"cogging": []}, parameters=amplitude)
    assert judged.errors == {"cogging": pytest.approx(0.0)}


@pytest.mark.parametrize(
    ("low", "high", "errors"),
    [
        ((-0.4, -0.4), (0.5, 0.5), {"position_torque": pytest.approx(0.125)}),
        # Joint 1 ends before its curve begins: it has no strength, and so no relative error.
        ((-0.4, -0.4), (0.05, 0.5), {"position_torque": pytest.approx(0.25)}),
        ((-0.4, -0.4), (0.05, 0.1), {}),
    ],
)
def test_strength_of_a_curve_is_its_peak_to_peak_value_over_the_travel(
    low: tuple[float, ...], high: tuple[float, ...], errors: dict[str, float]
) -> None:
    law = {"a": 5.0, "q_0": 0.1, "p": 2.0}
    truth = {"name": "position_torque", "joints": [1, 2], "parameters": law}
    values = {"g_11": -0.5, "g_91": 0.3, "g_12": 0.0, "g_92": 0.6}
    for joint in (1, 2):
        values |= {f"low{joint}": low[joint - 1], f"high{joint}": high[joint - 1]}
    named = {f"position_torque.{name}": value for name, value in values.items()}
    assert strengths.errors([truth], named) == errors


def test_interval_coverage_is_counted_for_each_joint() -> None:
    parameters = {"stribeck.a1": 1.1, "stribeck.a2": 0.7, "stribeck.v_s": 0.3}
    judged = judgement_of("single", ("stribeck",), "missing-effect", {"stribeck": []}, parameters=parameters)
    assert judged.covered == (True, False)
    assert judgement_of("single", ("stribeck",), "missing-effect", {"cogging": []}).covered == ()


def test_failed_diagnosis_is_never_right() -> None:
    case = HiddenCase("foreign", "nothing", (), (), "default", 1)
    judged = judge(case, {"effects": []}, {"error": "ValueError: no", "seconds": 0.1})
    assert not judged.right
    assert judged.problem == "ValueError: no"
