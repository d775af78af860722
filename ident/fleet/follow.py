"""Follow a fleet from night to night: what the robots have shown is kept, and only what is new is added to it.

`STORE/state/SETTINGS/robots/ROBOT.json` is what a robot has shown, `STORE/state/SETTINGS/course.json` what all robots
did. Both follow from the rows: what is damaged, or older than a recording that came late, is made anew of them.
"""

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import TypeVar

import pyarrow.compute as pc
from pydantic import TypeAdapter, ValidationError

from ident.fleet.common_course import Course, compare, forget, remember
from ident.fleet.evidence import METHOD, RobotEvidence
from ident.fleet.places import write
from ident.fleet.recording_rows import Row
from ident.fleet.series import KINDS, Nights, Series, day_of, nights_and_series
from ident.fleet.store import Store, file_name
from recordings.errors import BadInput

News = tuple[RobotEvidence, Nights, list[Series]]
"""What a robot has shown, and the series over its next nights."""
Run = Callable[[Callable[[News], RobotEvidence], Sequence[News]], Iterable[tuple[News, RobotEvidence | None]]]
"""How a function is applied to many items: an engine with its options."""
_WORTH_AN_ENGINE = 2000
"""Nights, of all robots together, that take longer here than other processes take to start: some ten seconds."""
_Content = TypeVar("_Content")
_EVIDENCE, _COURSE = TypeAdapter(RobotEvidence), TypeAdapter(Course)


def here(function: Callable[[News], RobotEvidence], items: Sequence[News]) -> Iterable[tuple[News, RobotEvidence]]:
    """Compute in this process."""
    return ((item, function(item)) for item in items)


def settle(store: Store) -> None:
    """Compare what is new with what all robots did, and put it where it belongs; go on where a run was killed.

    Raises:
        BadInput: the store is damaged, or cannot be written.
    """
    if rows := store.settled():
        _put_away(store, rows, _courses(store, rows))
    for paths in store.new():
        rows = store.read(paths)
        courses = _courses(store, rows)
        for settings, course in courses.items():
            compare(course, [row for row in rows if row["settings"] == settings])
        store.settle(rows, paths)
        _put_away(store, rows, courses)


def follow(store: Store, settings: str, run: Run = here) -> dict[str, RobotEvidence]:
    """What each robot has shown by now, of the settled rows with this digest of `settings`; it is kept, too.

    Raises:
        BadInput: the store is damaged, or cannot be written.
    """
    fleet, news = {}, list[News]()
    for robot, starts in _starts(store, settings).items():
        evidence = _load(_file(store, settings, robot), _EVIDENCE)
        if evidence is None or evidence.method != METHOD or not _goes_on(evidence.days, list(map(day_of, starts))):
            evidence = RobotEvidence(robot)
        fleet[robot] = evidence
        if len(evidence.days) < len(starts):
            news.append((evidence, *read(store, robot, settings, starts[len(evidence.days)])))
    if sum(len(nights.day) for _, nights, _ in news) < _WORTH_AN_ENGINE:
        run = here
    for item, advanced in run(_advanced, news):
        fleet[item[0].robot] = advanced or _advanced(item)
        keep(store, settings, fleet[item[0].robot])
    return fleet


def known(store: Store, settings: str) -> dict[str, RobotEvidence]:
    """What each robot had shown when the fleet was last followed.

    Raises:
        BadInput: the store is damaged.
    """
    fleet = {}
    for robot in _starts(store, settings):
        evidence = _load(_file(store, settings, robot), _EVIDENCE)
        if evidence is None:
            raise BadInput(
                f"{_file(store, settings, robot)}: what {robot} has shown expected, none found; "
                f"`ident fleet rebuild --store {store.folder}` makes it anew"
            )
        fleet[robot] = evidence
    return fleet


def rebuild(store: Store, settings: str, run: Run = here) -> None:
    """Make all that follows from the rows anew.

    Raises:
        BadInput: the store is damaged, or cannot be written.
    """
    for path in [*(store.folder / "state").rglob("*.json")]:
        path.unlink()
    store.index_anew()
    settle(store)
    follow(store, settings, run)


def read(store: Store, robot: str, settings: str, since: datetime | None = None) -> tuple[Nights, list[Series]]:
    """Nights and series of a `robot`, all of them or `since` a start.

    Raises:
        BadInput: the index of the store has recordings that it lacks, or a file is damaged.
    """
    table = store.rows_of(robot, settings, since)
    if since is not None:
        table = table.filter(pc.field("start") >= since)
    nights, series = nights_and_series(table, (*KINDS, "floor"))
    if not nights:
        raise BadInput(
            f"{store.folder}: rows of {robot} expected, none found; `ident fleet rebuild --store {store.folder}`, "
            "and run `ident fleet` again"
        )
    return nights[0], series


def keep(store: Store, settings: str, evidence: RobotEvidence) -> None:
    """Keep what a robot has shown."""
    write(_file(store, settings, evidence.robot), _EVIDENCE.dump_json(evidence))


def _advanced(news: News) -> RobotEvidence:
    evidence, nights, series = news
    evidence.go_on(nights, series)
    return evidence


def _goes_on(known: Sequence[float], days: Sequence[float]) -> bool:
    """Whether all recordings that are not `known` begin later than those."""
    count = len(known)
    return list(days[:count]) == list(known) and (count in (0, len(days)) or days[count] > known[-1])


def _starts(store: Store, settings: str) -> dict[str, list[datetime]]:
    """Starts of the usable recordings of each robot, in the order of time."""
    usable = (pc.field("settings") == settings) & (pc.field("status") == "done")
    starts: dict[str, list[datetime]] = defaultdict(list)
    for row in store.index().filter(usable).select(["robot", "start"]).sort_by("start").to_pylist():
        starts[row["robot"]].append(row["start"])
    return dict(sorted(starts.items()))


def _courses(store: Store, rows: Sequence[Row]) -> dict[str, Course]:
    """The courses by the digest of the settings, with what these `rows` add."""
    courses = {}
    for settings in sorted({row["settings"] for row in rows}):
        courses[settings] = _course(store, settings)
        remember(courses[settings], [row for row in rows if row["settings"] == settings])
    return courses


def _course(store: Store, settings: str) -> Course:
    course = _load(_course_file(store, settings), _COURSE)
    if course is None:
        course = {}
        for robot in _starts(store, settings):
            # Motions keep their numbers, in which a recording that came late is not at its place in time.
            order = [("motion_number", "ascending"), ("start", "ascending")]
            remember(course, store.rows_of(robot, settings).sort_by(order).to_pylist())
    return course


def _put_away(store: Store, rows: Sequence[Row], courses: Mapping[str, Course]) -> None:
    for settings, course in courses.items():
        forget(course)
        write(_course_file(store, settings), _COURSE.dump_json(course))
    store.put_away(rows)


def _course_file(store: Store, settings: str) -> Path:
    return store.folder / "state" / settings / "course.json"


def _file(store: Store, settings: str, robot: str) -> Path:
    return store.folder / "state" / settings / "robots" / f"{file_name(robot)}.json"


def _load(path: Path, kind: "TypeAdapter[_Content]") -> _Content | None:
    """Content of a file; None if there is none, or it is damaged."""
    try:
        return kind.validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None
