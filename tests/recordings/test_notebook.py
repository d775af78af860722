"""Progress below a cell: shown in a notebook, taken away at its end, and silent elsewhere."""

import sys
from types import SimpleNamespace
from typing import Any

import pytest

import ident
from recordings import notebook
from recordings.notebook import cell_progress
from tests.ident.building import record


@pytest.fixture
def cell(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What a notebook shows below its cell, one text after the other."""
    shown: list[str] = []

    def display(html: str, display_id: bool) -> Any:
        assert display_id
        shown.append(html)
        return SimpleNamespace(update=shown.append)

    tools = SimpleNamespace(HTML=str, display=display)
    kernel = SimpleNamespace(kernel=object())
    monkeypatch.setitem(sys.modules, "IPython", SimpleNamespace(get_ipython=lambda: kernel, display=tools))
    monkeypatch.setitem(sys.modules, "IPython.display", tools)
    monkeypatch.setattr(notebook, "_INTERVAL", 0.0)
    return shown


def test_activity_and_share_stand_below_the_cell_until_the_end(cell: list[str]) -> None:
    def interrupted() -> None:
        with cell_progress() as show:
            show("reading <b>")
            show("fitting", 3, 7)
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        interrupted()
    assert cell == [
        "<progress></progress> reading &lt;b&gt;",
        '<progress value="3" max="7"></progress> fitting',
        "",
    ]


def test_a_rapid_search_does_not_flood_the_browser(cell: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook, "_INTERVAL", 1e9)
    with cell_progress() as show:
        for step in range(100):
            show("fitting", step, 100)
    assert cell == ['<progress value="0" max="100"></progress> fitting', ""]


def test_calls_of_the_api_show_what_they_do(cell: list[str]) -> None:
    recording = record(noise=0.01)
    ident.fit(recording, method="ls")
    assert 'max="1"></progress> fitting' in cell[0]
    ident.check(recording)
    assert cell[-2:] == ["<progress></progress> looking at every effect", ""]
    before = len(cell)
    steps: list[tuple[int, int]] = []
    ident.fit(recording, method="ls", progress=lambda done, total, *_: steps.append((done, total)))
    assert steps == [(1, 1)]
    assert len(cell) == before


def test_outside_of_a_notebook_nothing_is_shown(capsys: pytest.CaptureFixture[str]) -> None:
    with cell_progress() as show:
        show("fitting", 1, 2)
    assert capsys.readouterr() == ("", "")
