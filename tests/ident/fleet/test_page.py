"""The page of a fleet holds the alarms first, every robot, and what cannot be used, and loads nothing."""

import re
from pathlib import Path

import numpy as np
import pytest

from ident.fleet import alarms, page
from ident.fleet.store import Store
from tests.ident.fleet.conftest import filled, rows_of, saved, step
from tests.ident.fleet.test_alarms import a_cause


@pytest.fixture
def store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Store:
    monkeypatch.setattr(
        alarms, "cause", lambda *_: a_cause(effect=None, verdict="unknown-structure", depends_on=("load",))
    )
    quiet = 1 + np.random.default_rng(1).normal(0, 0.01, (2, 20))
    broken = {**rows_of("r02", {"c_c1": np.ones(1)})[0], "key": "x", "status": "failed", "reason": "it is <empty>"}
    other = rows_of("r02", {"c_c1": quiet[1]})
    result = filled(tmp_path / "store", rows_of("r01", {"c_c1": step(), "c_c2": quiet[0]}), other, [broken])
    saved(result)
    return result


def test_page_shows_alarms_robots_and_reasons(store: Store, tmp_path: Path) -> None:
    page.write(store, alarms.load(store), tmp_path / "fleet.html")
    text = (tmp_path / "fleet.html").read_text(encoding="utf-8")
    assert "1 alarm is open" in text
    assert "r01: an unknown effect on joint 1 has been there since 2026-01-17; it depends on load." in text
    assert text.index('id="alarms"') < text.index('id="robots"')
    assert "r02: 20 recordings" in text
    assert "it is &lt;empty&gt;" in text
    assert "SIMULATED" in text
    assert not re.search(r"""<(img|script|link)[^>]+(src|href)=""", text)
    assert text.count("<svg") == 1 + 1 + 1 + 1, "at a glance, of the alarm, of each robot"
    assert len(text) < 1e5, "no library"


def test_acknowledged_alarm_is_no_longer_open(store: Store) -> None:
    alarms.acknowledge(store, ["r01-20260117"], "a new gear")
    text = page.render(store, alarms.load(store))
    assert "No alarm is open" in text
    assert "Note: a new gear" in text


def test_empty_fleet_has_a_page(tmp_path: Path) -> None:
    empty = filled(tmp_path / "empty")
    assert "No recording can be used." in page.render(empty, saved(empty))
