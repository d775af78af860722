"""What is found night by night is what is found in the whole history, whatever is killed, late or damaged."""

import json
import os
import pickle
import shutil
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import settings as hypothesis_settings
from hypothesis import strategies as st

from ident.fleet import alarms, follow
from ident.fleet.alarms import Alarm
from ident.fleet.evidence import RobotEvidence
from ident.fleet.follow import News, rebuild, settle
from ident.fleet.recording_rows import Row
from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from recordings.errors import BadInput
from tests.ident.fleet.conftest import filled, recordings_of, rows_of, saved, step
from tests.ident.fleet.test_alarms import a_cause

NIGHTS = 16
DIGEST = FleetSettings().digest
Advance = Callable[[News], RobotEvidence]


@pytest.fixture(autouse=True)
def diagnosed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(alarms, "cause", lambda *_: a_cause())


def drawn_fleet(seed: int, robots: int = 6, nights: int = NIGHTS) -> list[list[Row]]:
    """Recordings in the order of time, with a season, another motion, missing nights and events."""
    rng = np.random.default_rng(seed)
    season = 1 + 0.2 * np.sin(np.arange(nights) / 8)
    rows: list[Row] = []
    for robot in range(robots):
        motion = [[4.0, 0.9 if rng.random() < 0.1 else 0.5] for _ in range(nights)]
        values = {}
        for name in ("c_c1", "c_v2"):
            values[name] = season * (1 + rng.normal(0, 0.01, nights))
            if rng.random() < 0.4:
                values[name][rng.integers(nights // 3, nights - 1) :] *= 1 + rng.choice([-0.3, 0.3])
            values[name][rng.random(nights) < 0.05] = np.nan
        warm = 25 + 5 * rng.random(nights) if robot == 0 else None
        rows += rows_of(f"r{robot}", values, warm, motion)
    return sorted(recordings_of(rows), key=lambda of_one: (of_one[0]["start"], of_one[0]["key"]))


def added(store: Store, recordings: Sequence[list[Row]]) -> None:
    with store.locked():
        for of_one in recordings:
            store.add(of_one)
        settle(store)


def nightly(store: Store, recordings: Sequence[list[Row]], least: int = 0) -> tuple[Alarm, ...]:
    """Add recordings night by night, and find the alarms each time; the last ones."""
    starts = sorted({of_one[0]["start"] for of_one in recordings})
    added(store, [of_one for of_one in recordings if of_one[0]["start"] < starts[least]])
    found: tuple[Alarm, ...] = ()
    for start in starts[least:]:
        added(store, [of_one for of_one in recordings if of_one[0]["start"] == start])
        found = saved(store).alarms
    return found


def states(store: Store) -> dict[str, object]:
    return {path.name: json.loads(path.read_bytes()) for path in (store.folder / "state").rglob("robots/*.json")}


@hypothesis_settings(max_examples=2)
@given(st.integers(0, 2**32 - 1))
def test_night_by_night_is_the_whole_history(tmp_path_factory: pytest.TempPathFactory, seed: int) -> None:
    recordings, place = drawn_fleet(seed, robots=5, nights=12), tmp_path_factory.mktemp("fleet")
    whole = filled(place / "whole", *recordings[::-1])
    expected = saved(whole).alarms
    store = Store(place / "nightly")
    assert nightly(store, recordings, least=9) == expected
    assert states(store) == states(whole)
    assert store.table().equals(whole.table())


def test_rebuilt_state_is_as_it_was(tmp_path: Path) -> None:
    store = Store(tmp_path / "store")
    expected = nightly(store, drawn_fleet(1), least=12)
    assert expected
    before = states(store)
    for path in [*(store.folder / "state").rglob("*.json"), store.folder / "index.parquet"]:
        path.unlink()
    with store.locked():
        rebuild(store, DIGEST)
    assert states(store).keys() == before.keys()
    assert saved(store).alarms == expected
    assert states(store) == before


def test_damaged_state_and_late_recording_begin_anew(tmp_path: Path) -> None:
    rows = [*rows_of("r0", {"c_c1": step(NIGHTS, 9)}), *rows_of("r1", {"c_c1": step(NIGHTS, NIGHTS)})]
    recordings = recordings_of(rows)
    expected = saved(filled(tmp_path / "whole", *recordings)).alarms
    assert [alarm.robot for alarm in expected] == ["r0"]
    late = recordings.pop(5)
    store = filled(tmp_path / "store", *recordings)
    saved(store)
    next((store.folder / "state").rglob("robots/r1.json")).write_text("{")
    added(store, [late])
    assert saved(store).alarms == expected


def test_course_that_is_made_anew_has_the_same_numbers_of_motions(tmp_path: Path) -> None:
    motion = [[4.0, 0.5], [4.0, 0.9], [4.0, 0.7], [4.0, 0.7]]
    first, late, other, last = recordings_of(rows_of("r0", {"c_c1": np.ones(4)}, motion=motion))
    store = filled(tmp_path / "store", first, other)
    added(store, [late])
    next((store.folder / "state").rglob("course.json")).unlink()
    added(store, [last])
    assert store.table()["motion_number"].to_pylist()[::2] == [0, 2, 1, 1]


def test_engine_gives_the_same_although_a_worker_dies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(follow, "_WORTH_AN_ENGINE", 0)
    store = filled(tmp_path / "store", *drawn_fleet(4, robots=3, nights=8))
    follow.follow(store, DIGEST)
    expected = states(store)
    shutil.rmtree(store.folder / "state")

    def engine(function: Advance, items: Sequence[News]) -> Iterator[tuple[News, RobotEvidence | None]]:
        for number, item in reversed(list(enumerate(items))):
            sent_function, sent_item = pickle.loads(pickle.dumps((function, item)))
            yield item, sent_function(sent_item) if number else None

    assert sorted(follow.follow(store, DIGEST, engine)) == sorted(follow.known(store, DIGEST)) == ["r0", "r1", "r2"]
    assert states(store) == expected


def test_rows_that_were_removed_are_missed(tmp_path: Path) -> None:
    store = filled(tmp_path / "store", rows_of("r0", {"c_c1": step(3)}))
    next((store.folder / "recordings").glob("r0/*.parquet")).unlink()
    with pytest.raises(BadInput, match="rows of r0 expected, none found; `ident fleet rebuild"):
        saved(store)
    with store.locked():
        rebuild(store, DIGEST)
    assert saved(store).alarms == ()


STEPS = 11
"""Files that are replaced, and times that some are removed, when the last night of five robots is settled."""


@pytest.mark.parametrize("step", range(STEPS))
def test_run_that_is_killed_at_any_step_loses_and_repeats_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    recordings = drawn_fleet(3, robots=5, nights=2)
    expected = filled(tmp_path / "whole", *recordings).table()
    store = filled(tmp_path / "store", *recordings[:-5])
    with store.locked(), monkeypatch.context() as patch:
        for of_one in recordings[-5:]:
            store.add(of_one)
        steps = iter(range(STEPS))

        def killed_at(function: Callable[..., None]) -> Callable[..., None]:
            def called(*arguments: object) -> None:
                if next(steps) == step:
                    raise KeyboardInterrupt
                function(*arguments)

            return called

        patch.setattr(os, "replace", killed_at(os.replace))
        patch.setattr(Store, "_remove", killed_at(Store._remove))
        with pytest.raises(KeyboardInterrupt):
            settle(store)
    assert Store(store.folder).index().num_rows == len(recordings), "none twice"
    added(store, [])
    assert store.table().equals(expected)
    assert {path.parent.name for path in store.folder.rglob("recordings/*.parquet")} == set()
    assert saved(store).alarms == ()
