"""Ladders side by side: back, forth, and never lost by looking at another one."""

from typing import Any, cast

import pytest

from ident.workbench.branches import MAX_BRANCHES, Branches
from ident.workbench.views import LadderView
from recordings.errors import BadInput


class Ladder:
    """What branches look at of one."""

    always = ("rod_inertia",)

    def __init__(self, *added: str) -> None:
        self.rungs = [Rung("base model", ()), *(Rung(f"+ {added[-1]}", added) for _ in added[:1])]


class Rung:
    def __init__(self, label: str, added: tuple[str, ...]) -> None:
        self.label, self.terms = label, [(name, (1, 2, 3)) for name in ("rod_inertia", *added)]


def ladder(*added: str) -> LadderView:
    return cast(LadderView, cast(Any, Ladder(*added)))


def test_back_and_forth() -> None:
    base, one, two = ladder(), ladder("stribeck"), ladder("stribeck", "cogging")
    grown = Branches.start(base).extended(one).extended(two)
    assert grown.undone().current.ladder is one
    assert grown.undone().undone().redone().current.ladder is one
    assert grown.undone().redone().current.ladder is two
    assert not grown.undone().extended(ladder("backlash")).current.undone, "another way was taken"
    with pytest.raises(BadInput, match="began"):
        Branches.start(base).undone()
    with pytest.raises(BadInput, match="redo"):
        grown.redone()


def test_side_by_side() -> None:
    one = Branches.start(ladder()).extended(ladder("stribeck")).extended(ladder("stribeck", "cogging"))
    both = one.forked().undone().undone().extended(ladder("joint_spring"))
    assert [branch.title for branch in both.all] == ["A: stribeck + cogging", "B: joint_spring"]
    assert both.index == 1
    back = both.switched(0)
    assert back.current.title == "A: stribeck + cogging"
    assert back.undone().all[1].title == "B: joint_spring", "what is undone here stays there"
    assert [branch.name for branch in back.dropped(1).all] == ["A"]
    assert both.dropped(0).current.title == "B: joint_spring"
    assert both.dropped(0).forked().current.name == "A", "a name that is free again"


def test_impossible_branches() -> None:
    branches = Branches.start(ladder())
    with pytest.raises(BadInput, match="number 2"):
        branches.switched(1)
    with pytest.raises(BadInput, match="present one"):
        branches.dropped(0)
    for _ in range(MAX_BRANCHES - 1):
        branches = branches.forked()
    with pytest.raises(BadInput, match="drop one"):
        branches.forked()


def test_without_effects_a_branch_is_called_by_its_rung() -> None:
    assert Branches.start(ladder()).current.title == "A: base model"
