"""Branches: undo, redo, fork, switch and drop."""

from typing import Any, cast

import pytest

from ident.workbench.branches import MAX_BRANCHES, Branches
from ident.workbench.views import StepsView
from recordings.errors import BadInput


class LadderDouble:
    """Test double with the attributes of `StepsView` that branches use."""

    mandatory = ("rod_inertia",)

    def __init__(self, *added: str) -> None:
        self.steps = [StepDouble("base model", ()), *(StepDouble(f"+ {added[-1]}", added) for _ in added[:1])]


class StepDouble:
    def __init__(self, label: str, added: tuple[str, ...]) -> None:
        self.label, self.terms = label, [(name, (1, 2, 3)) for name in ("rod_inertia", *added)]


def step_list(*added: str) -> StepsView:
    return cast(StepsView, cast(Any, LadderDouble(*added)))


def test_undo_and_redo() -> None:
    base, first, second = step_list(), step_list("stribeck"), step_list("stribeck", "cogging")
    branches = Branches.start(base).extended(first).extended(second)
    assert branches.undone().current.step_list is first
    assert branches.undone().undone().redone().current.step_list is first
    assert branches.undone().redone().current.step_list is second
    assert not branches.undone().extended(step_list("backlash")).current.undone, (
        "a new change discards the undone ones"
    )
    with pytest.raises(BadInput, match="first model"):
        Branches.start(base).undone()
    with pytest.raises(BadInput, match="redo"):
        branches.redone()


def test_fork_switch_and_drop() -> None:
    single = Branches.start(step_list()).extended(step_list("stribeck")).extended(step_list("stribeck", "cogging"))
    both = single.forked().undone().undone().extended(step_list("joint_spring"))
    assert [branch.title for branch in both.all] == ["A: stribeck + cogging", "B: joint_spring"]
    assert both.index == 1
    back = both.switched(0)
    assert back.current.title == "A: stribeck + cogging"
    assert back.undone().all[1].title == "B: joint_spring", "undo in one branch leaves the other unchanged"
    assert [branch.name for branch in back.dropped(1).all] == ["A"]
    assert both.dropped(0).current.title == "B: joint_spring"
    assert both.dropped(0).forked().current.name == "A", "a name that is no longer used"


def test_impossible_changes_of_branches_are_refused() -> None:
    branches = Branches.start(step_list())
    with pytest.raises(BadInput, match="number 2"):
        branches.switched(1)
    with pytest.raises(BadInput, match="current one"):
        branches.dropped(0)
    for _ in range(MAX_BRANCHES - 1):
        branches = branches.forked()
    with pytest.raises(BadInput, match="drop one"):
        branches.forked()


def test_branch_without_added_effects_is_named_after_its_step() -> None:
    assert Branches.start(step_list()).current.title == "A: base model"
