"""Rows of made-up fleets, without recordings, and small recordings of one robot."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from datetime import UTC, datetime, timedelta
from itertools import groupby
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pyarrow as pa
import pytest

from ident.fleet import alarms
from ident.fleet.alarms import FleetFile
from ident.fleet.common_course import Course, compare, remember
from ident.fleet.discoveries import Event, events
from ident.fleet.engines import EngineOptions
from ident.fleet.evidence import RobotEvidence
from ident.fleet.follow import settle
from ident.fleet.recording_rows import Row
from ident.fleet.series import Nights, Series, nights_and_series
from ident.fleet.settings import FleetSettings
from ident.fleet.store import SCHEMA, Store
from ident.fleet.update import Count, plan, update
from recordings.recording import Floats, Recording

FIRST = datetime(2026, 1, 5, 22, tzinfo=UTC)
HALF_WIDTH = 0.01
_OPTIONS = EngineOptions()


def rows_of(
    robot: str,
    values: Mapping[str, Floats],
    temperature: Floats | None = None,
    motion: list[list[float]] | None = None,
) -> list[Row]:
    """Rows of one recording per night; values: (n,) of each name, NaN where a recording does not show it."""
    rows: list[Row] = []
    count = len(next(iter(values.values())))
    for night in range(count):
        about: Row = {
            "key": f"{robot}-{night:03d}",
            "settings": FleetSettings().digest,
            "content": f"{robot}{night}",
            "path": f"/fleet/{robot}/{night:03d}.mcap",
            "size": 1,
            "changed": 1,
            "robot": robot,
            "start": FIRST + timedelta(days=night),
            "simulated": True,
            "seconds": 8.0,
            "motion": motion[night] if motion else [4.0, 0.5, 0.5, 0.5],
            "temperature": None if temperature is None else float(temperature[night]),
            "kind": "recording",
            "name": "recording",
            "status": "done",
        }
        rows.append(about)
        for name, series in values.items():
            if np.isfinite(series[night]):
                value = float(series[night])
                interval = {"value": value, "low": value - HALF_WIDTH, "high": value + HALF_WIDTH}
                rows.append(
                    {**about, "kind": "parameter", "name": name, "joint": int(name[-1]), "unit": "N m", **interval}
                )
    return rows


def step(nights: int = 20, since: int = 12) -> Floats:
    """(nights,) a quantity that rises by 30 % of itself, and scatters by 1 %."""
    scatter = np.random.default_rng(0).normal(0, 0.01, nights)
    return 1 + scatter + 0.3 * (np.arange(nights) >= since)


def settled(rows: list[Row]) -> list[Row]:
    """The `rows` of recordings that all are new, as the store keeps them."""
    course: Course = {}
    ordered = sorted(rows, key=lambda row: row["start"])
    remember(course, ordered)
    compare(course, ordered)
    return ordered


def series_of(rows: list[Row]) -> tuple[list[Nights], list[Series]]:
    return nights_and_series(pa.Table.from_pylist(settled(rows), SCHEMA))


def events_of(
    series: Sequence[Series], repaired: Mapping[str, Sequence[float]] = MappingProxyType({})
) -> list[Event]:
    """Events of a fleet, of its whole history."""
    fleet: dict[str, RobotEvidence] = {}
    of_robot = {each.nights.robot: [other for other in series if other.nights is each.nights] for each in series}
    for robot, of_one in of_robot.items():
        fleet[robot] = RobotEvidence(robot)
        fleet[robot].go_on(of_one[0].nights, of_one)
    return events(fleet, repaired, of_robot.__getitem__)


def recordings_of(rows: list[Row]) -> list[list[Row]]:
    """Rows by recording."""
    return [list(of_one) for _, of_one in groupby(rows, key=lambda row: row["key"])]


def filled(folder: Path, *rows: list[Row]) -> Store:
    """A store with the recordings that have these rows."""
    store = Store(folder)
    with store.locked():
        for of_one in (of_one for some in rows for of_one in recordings_of(some)):
            store.add(of_one)
        settle(store)
    return store


def saved(store: Store) -> FleetFile:
    """Find and keep the alarms of a store, as `ident fleet` does."""
    with store.locked():
        alarms.save(store, alarms.find(store, FleetSettings(), [Path("recordings")], {}))
    return alarms.load(store)


def brought_up_to_date(
    store: Store,
    folder: Path,
    engine: str = "serial",
    options: EngineOptions = _OPTIONS,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Count:
    settings = FleetSettings()
    with store.locked():
        return update(store, plan(store, [folder], settings), settings, engine, options, progress)


@pytest.fixture(scope="session")
def night(make: Callable[..., Recording], write: Callable[[Recording], Path]) -> Callable[..., Path]:
    """Write the recording of one night; the robot is "r01" unless another is named."""

    def written(
        path: Path, number: int, robot: str | None = "r01", start: str | None = None, **options: object
    ) -> Path:
        made = make("fig5a", cycles=1, rate=250.0, noise=0.01, seed=number, path=path, **options)
        begin = start or (FIRST + timedelta(days=number)).isoformat()
        return write(replace(made, run=made.run.model_copy(update={"start": begin, "robot": robot})))

    return written
