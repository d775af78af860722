"""Alarms of a store: found, kept, acknowledged, and diagnosed once."""

from datetime import date
from pathlib import Path

import numpy as np
import pytest

from ident.fleet import alarms
from ident.fleet.cause import Cause
from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from recordings.errors import BadInput
from tests.ident.fleet.conftest import filled, rows_of, saved, step


def a_cause(**other: object) -> Cause:
    content = {
        "verdict": "missing-effect",
        "effect": "stribeck",
        "joints": (1,),
        "confusable_with": ("cogging",),
        "origin": "mechanics",
        "explained": 0.9,
        "torque_share": 0.02,
        "depends_on": (),
        "before": ("/a.mcap",),
        "after": ("/b.mcap",),
        "why": "stribeck explains 90 % of what is different since then",
    }
    return Cause.model_validate({**content, **other})


@pytest.fixture
def store(tmp_path: Path) -> Store:
    return filled(tmp_path / "store", rows_of("r07", {"c_c1": step()}))


@pytest.fixture
def diagnosed(monkeypatch: pytest.MonkeyPatch) -> list[object]:
    """The events that were diagnosed."""
    seen: list[object] = []
    monkeypatch.setattr(alarms, "cause", lambda event, *_: seen.append(event) or a_cause())
    return seen


def test_alarm_says_who_what_and_since_when(store: Store, diagnosed: list[object]) -> None:
    (alarm,) = saved(store).alarms
    assert (alarm.id, alarm.robot, alarm.effect, alarm.joints) == ("r07-20260117", "r07", "stribeck", (1,))
    assert (alarm.since, alarm.kind, alarm.acknowledged) == ("2026-01-17", "sudden", False)
    assert alarm.since_ci95[0] <= alarm.since <= alarm.since_ci95[1]
    assert alarm.shown_by == ("c_c1",)
    assert alarm.log10_e > 4


def test_same_recordings_are_diagnosed_once(store: Store, diagnosed: list[object]) -> None:
    assert saved(store) == saved(store)
    assert len(diagnosed) == 1


def test_acknowledged_alarm_stays_so_until_it_is_undone(store: Store, diagnosed: list[object]) -> None:
    saved(store)
    alarms.acknowledge(store, ["r07-20260117"], "gear replaced")
    (alarm,) = saved(store).alarms
    assert (alarm.acknowledged, alarm.note) == (True, "gear replaced")
    alarms.acknowledge(store, ["r07", "stribeck"], "", undo=True)
    assert not alarms.load(store).alarms[0].acknowledged


def test_repair_begins_a_new_baseline(tmp_path: Path, diagnosed: list[object]) -> None:
    values = step(30, 12) - 0.3 * (np.arange(30) >= 17)
    store = filled(tmp_path / "store", rows_of("r07", {"c_c1": values}))
    worn, back = saved(store).alarms
    assert (worn.since, back.since) == ("2026-01-17", "2026-01-22")
    with pytest.raises(BadInput, match="a date since 2026-01-17 expected"):
        alarms.acknowledge(store, [worn.id], "", repaired=date(2026, 1, 16))
    alarms.acknowledge(store, [worn.id], "new gear", repaired=date(2026, 1, 22))
    assert [alarm.id for alarm in saved(store).alarms] == [worn.id]
    alarms.acknowledge(store, [worn.id], "", undo=True)
    assert saved(store).alarms == (worn, back)


def test_unknown_alarm_and_missing_or_damaged_result_are_refused(store: Store, diagnosed: list[object]) -> None:
    with pytest.raises(BadInput, match="run it to its end"):
        alarms.load(store)
    saved(store)
    with pytest.raises(BadInput, match=r"\(r07-20260117\), 'r8' found"):
        alarms.acknowledge(store, ["r8"], "")
    (store.folder / "fleet.json").write_text("{")
    with pytest.raises(BadInput, match="is not valid JSON"):
        alarms.load(store)


def test_rows_of_other_settings_are_left_out(store: Store, diagnosed: list[object]) -> None:
    assert alarms.find(store, FleetSettings(cutoff=20.0), (), {}).alarms == ()
