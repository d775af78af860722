"""What a night costs in a fleet that is watched for years: `python -m benchmarks.fleet.years FOLDER`.

The rows are made up: a season, missing nights, events; no recording is read, so that no cause is found. A few robots
have a history of their own, which is gathered night by night; the others are copies of them under other names.
"""

import json
import resource
import sys
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from datetime import UTC, datetime, timedelta
from multiprocessing import get_context
from pathlib import Path

import click
import numpy as np
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ident.fleet import alarms, page
from ident.fleet.alarms import Alarm
from ident.fleet.common_course import Course, compare, forget, remember
from ident.fleet.follow import follow, settle
from ident.fleet.recording_rows import Row
from ident.fleet.settings import FleetSettings
from ident.fleet.store import SCHEMA, Store
from recordings.progress import progress_bar
from recordings.recording import Floats

FIRST = datetime(2023, 1, 2, 22, tzinfo=UTC)
JOINTS = 3
PARAMETERS = [f"{name}{joint}" for name in ("I_", "c_v", "c_c", "T_g") for joint in range(1, JOINTS + 1)]
SCATTER = 0.01
"""Of a parameter from night to night, relative; its interval is as wide."""
SETTINGS = FleetSettings()


def made_up(seed: int, nights: int) -> Floats:
    """(nights, parameters) of one robot, with about one event in a year; NaN in missing nights."""
    rng = np.random.default_rng(seed)
    season = 1 + 0.1 * np.sin(2 * np.pi * np.arange(nights) / 365)
    values: Floats = season[:, None] * (1 + SCATTER * rng.normal(size=(nights, len(PARAMETERS))))
    for _ in range(rng.poisson(nights / 365)):
        values[rng.integers(nights) :, rng.integers(len(PARAMETERS))] *= 1 + rng.choice([-0.2, 0.2])
    values[rng.random(nights) < 0.03] = np.nan
    return values


def rows_of(robot: str, night: int, values: Floats) -> list[Row]:
    """Rows of one recording of a `robot` with these values (parameters,)."""
    start = FIRST + timedelta(days=night)
    identity = f"{robot}-{night}"
    about: Row = {
        "key": identity,
        "settings": SETTINGS.digest,
        "content": identity,
        "path": f"/fleet/{robot}/{night:04d}.mcap",
        "size": 1,
        "changed": 1,
        "robot": robot,
        "start": start,
        "simulated": True,
        "seconds": 8.0,
        "motion": [4.0, *[0.5] * JOINTS],
        "temperature": None,
        "status": "done",
    }
    rows = [{**about, "kind": "recording", "name": "recording"}]
    for name, value in zip(PARAMETERS, values.tolist(), strict=True):
        interval = {"value": value, "low": value - SCATTER, "high": value + SCATTER}
        rows.append({**about, "kind": "parameter", "name": name, "joint": int(name[-1]), "unit": "N m", **interval})
    return rows


def nights_of(values: dict[str, Floats], nights: Sequence[int]) -> Iterator[list[Row]]:
    """Rows of the recordings of all robots in these `nights`."""
    for night in nights:
        for robot, of_robot in values.items():
            if np.isfinite(of_robot[night, 0]):
                yield rows_of(robot, night, of_robot[night])


def added(store: Store, recordings: Sequence[list[Row]]) -> tuple[Alarm, ...]:
    """Settle recordings, and find the alarms."""
    with store.locked():
        for rows in recordings:
            store.add(rows)
        settle(store)
        result = alarms.find(store, SETTINGS, [Path("/fleet")], {})
        alarms.save(store, result)
    return result.alarms


def make_history(store: Store, values: dict[str, Floats], nights: int) -> None:
    """Fill the `store` with what is known before the last night, a month at a time."""
    course: Course = {}
    with store.locked(), progress_bar("making rows") as show:
        for first in range(0, nights, 30):
            show("making rows", first, nights)
            rows = [row for of_one in nights_of(values, range(first, min(first + 30, nights))) for row in of_one]
            remember(course, rows)
            compare(course, rows)
            forget(course)
            store.settle(rows, [])
            settle(store)
        show("gathering evidence", 0, 0)
        follow(store, SETTINGS.digest)


def copy(store: Store, sources: Sequence[str], names: Sequence[str]) -> None:
    """Give robots of other `names` the history of those that have one."""
    state = store.folder / "state" / SETTINGS.digest
    course = json.loads((state / "course.json").read_bytes())
    for number, name in enumerate(names):
        source = sources[number % len(sources)]
        (store.folder / "recordings" / name).mkdir()
        for path in (store.folder / "recordings" / source).glob("*.parquet"):
            table = pq.read_table(path, schema=SCHEMA)
            for column in ("key", "content", "path", "robot"):
                renamed = pc.replace_substring(table[column], source, name)
                table = table.set_column(SCHEMA.get_field_index(column), SCHEMA.field(column), renamed)
            pq.write_table(table, path.parent.with_name(name) / path.name)
        text = (state / "robots" / f"{source}.json").read_text(encoding="utf-8")
        renamed_state = text.replace(f'"robot":"{source}"', f'"robot":"{name}"')
        (state / "robots" / f"{name}.json").write_text(renamed_state, encoding="utf-8")
        course[name] = course[source]
    (state / "course.json").write_text(json.dumps(course), encoding="utf-8")
    with store.locked():
        store.index_anew()


def one_night(folder: Path, recordings: Sequence[list[Row]]) -> tuple[float, float, int]:
    """Time of one more night [s], largest memory [MiB], and the number of alarms."""
    begin = time.monotonic()
    found = added(Store(folder), recordings)
    seconds = time.monotonic() - begin
    return seconds, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, len(found)


def same_as_whole_history(folder: Path, seed: int, robots: int = 6, nights: int = 40) -> bool:
    """Whether a small fleet has the same alarms night by night as in its whole history."""
    values = {f"r{number}": made_up(1000 * seed + number, nights) for number in range(robots)}
    nightly, whole = Store(folder / f"{seed}-nightly"), Store(folder / f"{seed}-whole")
    added(nightly, list(nights_of(values, range(nights - 15))))
    found = [added(nightly, list(nights_of(values, [night]))) for night in range(nights - 15, nights)]
    return found[-1] == added(whole, list(nights_of(values, range(nights))))


@click.command()
@click.argument("folder", type=click.Path(path_type=Path))
@click.option("--robots", default=200, show_default=True, type=click.IntRange(1))
@click.option("--nights", default=1095, show_default=True, type=click.IntRange(30))
@click.option(
    "--own", default=10, show_default=True, type=click.IntRange(1), help="Robots with a history of their own."
)
@click.option(
    "--fleets", default=20, show_default=True, type=click.IntRange(0), help="Small fleets that are compared."
)
def main(folder: Path, robots: int, nights: int, own: int, fleets: int) -> None:
    """Time one more night of a fleet in FOLDER, and compare small fleets with their whole history."""
    names = [f"r{number:03d}" for number in range(robots)]
    values = {name: made_up(seed, nights + 1) for seed, name in enumerate(names[:own])}
    values |= {name: values[names[number % own]] for number, name in enumerate(names)}
    store = Store(folder / "years")
    if not store.folder.exists():
        make_history(store, {name: values[name] for name in names[:own]}, nights)
        copy(store, names[:own], names[own:])
        alarms.acknowledge(store, [alarm.id for alarm in added(store, [])], "known")
    recordings = list(nights_of(values, [nights]))
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        for what in ("one more night", "nothing new"):
            seconds, memory, found = pool.submit(one_night, store.folder, recordings).result()
            print(
                f"{what}: {seconds:.1f} s, {memory:.0f} MiB, {found} alarms of {robots} robots, {nights + 1} nights"
            )
            recordings = []
    same = sum(same_as_whole_history(folder / "small", seed) for seed in range(fleets))
    size = len(page.render(store, alarms.load(store)).encode()) / 1e6
    print(f"page: {size:.2f} MB")
    print(f"{same} of {fleets} small fleets have the alarms of their whole history")
    sys.exit(same < fleets)


if __name__ == "__main__":
    main()
