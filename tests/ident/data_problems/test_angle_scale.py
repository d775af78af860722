"""Angles beyond what a URDF allows: degrees, or those of motors before their gears."""

import re

import numpy as np
import pytest

from ident.data_problems import check_data, kind_names
from recordings.data_problems import DataProblem

pytest.importorskip("pinocchio")

from tests.ident import arms

TRUE = arms.urdf(arms.LIFTING)


def problems(scale: float, limits: str, axes: tuple[str, ...] = arms.LIFTING) -> tuple[DataProblem, ...]:
    return check_data([arms.record(arms.urdf(axes), arms.urdf(axes, limits=limits), scale=scale)]).data_problems


@pytest.mark.parametrize(("scale", "kind"), [(180 / np.pi, "angle-unit"), (5, "gear-ratio"), (100, "gear-ratio")])
def test_the_scale_at_which_the_torque_agrees_tells_which(scale: float, kind: str) -> None:
    (problem,) = problems(scale, limits="-1 1")
    assert (problem.kind, problem.blocks) == (kind, True)
    low, high = map(float, re.findall(r"divided by (\S+) to (\S+),", problem.why)[0])
    assert low < scale < high < 4 * low
    assert "position_1=position_1:" in problem.remedy
    assert problem.kind in kind_names()


def test_a_motion_that_does_not_tell_leaves_an_or() -> None:
    (problem,) = problems(100, "-1 1", arms.SHOULDER)
    assert problem.kind == "angle-unit"
    assert "or more, the angles agree with the torque: they are in degrees" in problem.why
    assert "or gears have such a ratio" in problem.why
    assert problem.remedy.startswith("State the unit of each joint")


@pytest.mark.parametrize("limits", ["0 0", "-1 1", "-0.1 0.1", "none none"])
def test_nothing_is_said_of_what_a_joint_may_do_whatever_the_limits_are(limits: str) -> None:
    assert problems(1.0, limits=limits) == ()


def test_without_limits_nothing_tells() -> None:
    assert not {"gear-ratio", "angle-unit"} & {each.kind for each in problems(21, limits="0 0")}


def test_gears_that_differ_from_joint_to_joint_are_told_apart() -> None:
    recording, gears = arms.record(TRUE), (30, 81)
    recording.position[:] *= gears
    (problem,) = check_data([recording]).data_problems
    assert problem.kind == "gear-ratio"
    found = re.findall(r"divided by about (.+), the angles", problem.why)[0]
    assert [float(word) for word in found.split(", ")] == pytest.approx(gears, rel=0.1)
    assert "State the unit of each joint" in problem.remedy


def test_counts_are_no_angles_of_motors() -> None:
    (problem,) = problems(1e5, "-1 1")
    assert problem.kind == "angle-unit"
    assert "counts" in problem.remedy


def test_angles_that_agree_with_no_torque_are_named_nevertheless() -> None:
    recording = arms.record(TRUE, scale=80)
    assert recording.effort is not None
    recording.effort[:] = np.random.default_rng(0).permutation(recording.effort - recording.effort.mean(axis=0))
    (problem, *_) = check_data([recording]).data_problems
    assert problem.kind == "gear-ratio"
    assert "divided by no numbers" in problem.why
