"""What changed is drawn, once, and only where it can be seen. No browser and no server runs."""

from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import pytest

from ident.workbench.pages.page import Page
from ident.workbench.topics import Changes


@pytest.fixture
def page() -> Page:
    session = SimpleNamespace(changes=Changes(), display=SimpleNamespace(tab="data"))
    return Page(cast(Any, session), cast(Any, None))


def counter() -> tuple[list[int], Callable[[Page], None]]:
    calls: list[int] = []
    return calls, lambda page: calls.append(1)


def test_change_during_the_first_drawing_is_not_lost(page: Page) -> None:
    seen = []
    state = {"cards": 0}

    def draw(page: Page) -> None:
        seen.append(state["cards"])
        if len(seen) == 1:  # another thread brings the cards just after they were looked at
            state["cards"] = 5
            page.session.changes.mark("candidates")

    page.call_now_and_on_change(draw, "candidates")
    page.poll()
    page.poll()
    assert seen == [0, 5]


def test_hidden_tab_is_drawn_when_it_is_shown(page: Page) -> None:
    calls, draw = counter()
    page.drawn_tab = "robot"
    page.call_now_and_on_change(draw, "series")
    page.session.changes.mark("series")
    page.poll()
    assert not calls
    page.show("robot")
    page.poll()
    assert len(calls) == 1
    page.show("data")
    page.session.changes.mark("series")
    page.session.changes.mark("series")
    page.poll()
    assert len(calls) == 1
    page.show("robot")
    assert len(calls) == 2


def test_frequent_changes_are_drawn_at_intervals(page: Page) -> None:
    calls, draw = counter()
    page.call_now_and_on_change(draw, "run", min_interval=60.0)
    page.session.changes.mark("run")
    page.poll()
    assert len(calls) == 1


def test_message_that_was_shown_before_is_not_shown_again(page: Page) -> None:
    calls, show = counter()
    page.session.changes.mark("message")
    page.call_on_change(show, "message")
    page.poll()
    assert not calls
    page.session.changes.mark("message")
    page.poll()
    assert len(calls) == 1
