"""The parts of the benchmark in one table."""

from benchmarks.hidden_effects.tables import lines
from tests.benchmarks.hidden_effects.test_scoring import judgement_of


def test_parts_stand_side_by_side_and_failures_below() -> None:
    right = judgement_of("nothing", (), "adequate", {"rod_inertia": []})
    wrong = judgement_of("nothing", (), "missing-effect", {"stribeck": []})
    printed = list(lines({"tuned": [right], "locked": [wrong]}))
    assert printed[0].split() == ["required", "tuned", "locked"]
    (row,) = (line for line in printed if line.startswith("nothing hidden"))
    assert "100.0 % (20.7-100.0) of 1" in row
    assert row.endswith("0.0 % (0.0-79.3) of 1 !")
    assert not any("pairs" in line for line in printed)
    assert "\ntuned: 1 cases" in printed
    assert "\n0 cases that were not right" in printed
    assert "\n1 cases that were not right" in printed


def test_right_effects_on_other_joints_are_listed() -> None:
    judged = judgement_of("single", ("cogging",), "missing-effect", {"cogging": []})
    printed = list(lines({"tuned": [judged]}))
    listed = printed[printed.index("\n1 cases on other joints") + 1 :]
    assert listed[0].startswith("  single-cogging-3%")
    assert "\n1 cases with a held-out error above 1.1 noise floors" in listed
