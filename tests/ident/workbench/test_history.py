"""The history: nothing is lost by going back, and what is added there is a branch."""

from types import SimpleNamespace
from typing import Any, cast

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ident.workbench.state.history import Entry, History
from recordings.errors import BadInput


def made(*effects: str, findings: object = None) -> Any:
    added = tuple((effect, (1,)) for effect in effects)
    step = SimpleNamespace(label="base model", terms=added)
    return cast(Any, SimpleNamespace(steps=(step,), added=added, findings=findings))


def test_what_is_added_after_an_undo_is_a_branch() -> None:
    history = History.start(made()).extended(made("stribeck")).extended(made("stribeck", "cogging"))
    back = history.at(history.undo).at(1).at(0)
    assert (back.undo, back.redo) == (None, 1)
    both = back.extended(made("joint_spring"))
    assert [both.title(end) for end in both.ends] == ["1: stribeck + cogging", "2: joint_spring"]
    assert (both.end, both.undo, both.redo) == (3, 0, None)
    first = both.at(2)
    assert (first.end, first.undo, first.at(0).redo) == (2, 1, 1), "redo stays in the branch"
    assert [each.made.added for each in first.without(3).entries] == [each.made.added for each in history.entries]
    left = both.without(2)
    assert [left.title(end) for end in left.ends] == ["1: joint_spring"]
    assert (left.current, left.undo) == (1, 0)


def test_the_same_once_more_is_no_branch() -> None:
    history = History.start(made()).extended(made("stribeck"))
    again = history.at(0).extended(other := made("stribeck"))
    assert (again.made, [again.title(end) for end in again.ends]) == (other, ["1: stribeck"])
    diagnosed = again.at(0).extended(made("stribeck", findings="found"))
    assert [diagnosed.title(end) for end in diagnosed.ends] == ["1: stribeck", "2: stribeck (full diagnosis)"]


def test_what_is_not_there_is_refused() -> None:
    history = History.start(made()).extended(made("stribeck"))
    for number in (None, -1, 2):
        with pytest.raises(BadInput, match="another model of the history"):
            history.at(number)
    for end in (0, 1):
        with pytest.raises(BadInput, match="other than the current one"):
            history.without(end)


@pytest.mark.parametrize(("before", "current", "end"), [((None, 1), 0, 1), ((None, 0), 2, 1), ((None, 0), 1, 0)])
def test_a_damaged_history_is_refused(before: tuple[int | None, ...], current: int, end: int) -> None:
    with pytest.raises(ValueError, match="a current model"):
        History(tuple(Entry(made(), number) for number in before), current, end)


@given(st.lists(st.integers(0, 30), max_size=30))
def test_no_way_through_the_history_loses_a_model(choices: list[int]) -> None:
    history = History.start(made("0"))
    for number, choice in enumerate(choices, 1):
        history = history.at(choice % len(history.entries)).extended(made(str(number)))
    assert [entry.made.added[0][0] for entry in history.entries] == [str(n) for n in range(len(choices) + 1)]
    for number in range(len(history.entries)):
        there = history.at(number)
        assert there.made is history.entries[number].made
        assert there.redo is None or there.at(there.redo).at(there.at(there.redo).undo).current == number
    for end in set(history.ends) - {history.end}:
        fewer = history.without(end)
        assert fewer.made is history.made
        assert {entry.made.added for entry in fewer.entries} < {entry.made.added for entry in history.entries}
