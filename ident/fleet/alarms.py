"""The alarms of a fleet: what changed on which robot since when, and whether somebody knows of it.

`STORE/fleet.json` holds the last result, `STORE/acknowledged.json` what was acknowledged, and `STORE/causes/` the
diagnoses of events, which are made once for the same recordings.
"""

import hashlib
import json
from collections import defaultdict
from collections.abc import Callable, Mapping, Sequence
from datetime import date
from functools import cache, partial
from pathlib import Path
from typing import Literal, TypeVar

from pydantic import Field

from ident.fleet.cause import METHOD, Cause, cause, chosen_nights
from ident.fleet.discoveries import Event, events
from ident.fleet.follow import Run, follow, here, keep, read
from ident.fleet.places import content, write
from ident.fleet.series import Nights, Series, day_of_date, moment
from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from recordings.config import ConfigSection, validated
from recordings.errors import BadInput
from recordings.limits import json_object

_Content = TypeVar("_Content", bound=ConfigSection)


class Alarm(Cause):
    """One alarm, as `ident fleet --json` prints it: an event and its cause."""

    id: str
    """By which it is acknowledged."""
    robot: str
    since: str
    """Date of the first recording with it (UTC)."""
    since_ci95: tuple[str, str]
    kind: Literal["sudden", "growing"]
    per_day: float | None
    """Of the quantity that shows it best: change per day of one that grows, in its unit or relative."""
    shown_by: tuple[str, ...]
    """Quantities that changed, the clearest first."""
    log10_e: float
    """Decimal logarithm of the e-value."""
    acknowledged: bool
    note: str = ""


class Acknowledgement(ConfigSection):
    """An alarm that somebody knows of."""

    robot: str
    since_ci95: tuple[str, str]
    note: str = ""
    repaired: date | None = None
    """From then on the robot has a new baseline."""


class Acknowledgements(ConfigSection):
    """Content of `acknowledged.json`."""

    schema_version: Literal[1] = Field(1, alias="schema")
    alarms: tuple[Acknowledgement, ...] = ()

    def repaired_on(self) -> dict[str, list[float]]:
        """Days of the repairs of each robot [days since 1970]."""
        days: dict[str, list[float]] = defaultdict(list)
        for entry in self.alarms:
            if entry.repaired is not None:
                days[entry.robot].append(day_of_date(str(entry.repaired)))
        return days


class FleetFile(ConfigSection):
    """Content of `fleet.json`."""

    schema_version: Literal[1] = Field(1, alias="schema")
    settings: str
    """Digest of the settings and the method of the last run."""
    folders: tuple[str, ...]
    recordings: dict[str, int]
    alarms: tuple[Alarm, ...]
    events: tuple[str, ...]
    """Digest of what each of the alarms says: an event that is as it was keeps its alarm."""


def find(
    store: Store,
    settings: FleetSettings,
    folders: Sequence[Path],
    counts: Mapping[str, int],
    progress: Callable[[int, int], None] = lambda done, total: None,
    run: Run = here,
) -> FleetFile:
    """The result, with the alarms of the recordings in the `store` that were analysed with these `settings`.

    folders, counts: of the recordings; run: an engine, on which evidence is gathered robot by robot.

    Raises:
        BadInput: the store is damaged, or cannot be written.
    """
    fleet = follow(store, settings.digest, run)
    before = {robot: set(evidence.since) for robot, evidence in fleet.items()}
    of_robot = cache(partial(read, store, settings=settings.digest))
    acknowledged, last = _acknowledgements(store), _load(_fleet(store), FleetFile)
    fleet_events = events(fleet, acknowledged.repaired_on(), lambda robot: of_robot(robot)[1])
    for robot, evidence in fleet.items():
        if set(evidence.since) != before[robot]:
            keep(store, settings.digest, evidence)
    known = dict(zip(last.events, last.alarms, strict=True)) if last else {}
    found = {}
    for done, event in enumerate(fleet_events):
        progress(done, len(fleet_events))
        identity = _digest([event.robot, event.segment, repr(event.changes), settings.digest, METHOD])
        found[identity] = known.get(identity) or _alarm(
            event, fleet[event.robot].days, _cause(store, event, *of_robot(event.robot), settings)
        )
    return FleetFile(
        schema=1,
        settings=settings.digest,
        folders=tuple(map(str, folders)),
        recordings=dict(counts),
        alarms=tuple(_with_acknowledgement(alarm, acknowledged) for alarm in found.values()),
        events=tuple(found),
    )


def save(store: Store, content: FleetFile) -> None:
    """Write `fleet.json`."""
    write(_fleet(store), _json(content))


def load(store: Store) -> FleetFile:
    """Read the last result.

    Raises:
        BadInput: there is none, or it is damaged.
    """
    content = _load(_fleet(store), FleetFile)
    if content is None:
        raise BadInput(
            f"{store.folder}: a store of `ident fleet` expected, no {_fleet(store).name} found; run it to its end"
        )
    known = _acknowledgements(store)
    return content.model_copy(
        update={"alarms": tuple(_with_acknowledgement(alarm, known) for alarm in content.alarms)}
    )


def unheard(store: Store, alarms: Sequence[Alarm]) -> list[Alarm]:
    """The open ones of the `alarms` that the last result in the `store` does not have."""
    last = _load(_fleet(store), FleetFile)
    known = Acknowledgements(schema=1, alarms=tuple(map(_known, last.alarms if last else ())))
    return [each for each in alarms if not (each.acknowledged or _with_acknowledgement(each, known).acknowledged)]


def _known(alarm: Alarm, note: str = "", repaired: date | None = None) -> Acknowledgement:
    return Acknowledgement(robot=alarm.robot, since_ci95=alarm.since_ci95, note=note, repaired=repaired)


def acknowledge(
    store: Store, words: Sequence[str], note: str, undo: bool = False, repaired: date | None = None
) -> list[Alarm]:
    """Acknowledge alarms, or take that back; return those concerned.

    words: ids of alarms, or a robot and the effect (or verdict) of alarms of it.
    repaired: from then on their robots have a new baseline.

    Raises:
        BadInput: there is no such alarm, or it began after the repair.
    """
    alarms = {alarm.id: alarm for alarm in load(store).alarms}
    of_effect = ([each.robot, each.effect or each.verdict] for each in alarms.values())
    ids = [identity for identity, named in zip(alarms, of_effect, strict=True) if named == [*words]] or words
    for identity in ids:
        if identity not in alarms:
            listing = ", ".join(alarms) or "none"
            raise BadInput(f"an alarm of this store expected ({listing}), '{identity}' found; choose one of them")
        if repaired is not None and str(repaired) < alarms[identity].since:
            raise BadInput(
                f"--repaired: a date since {alarms[identity].since} expected, when {identity} began, {repaired} found"
            )
    chosen = [alarms[identity] for identity in ids]
    kept = [
        entry for entry in _acknowledgements(store).alarms if not any(_concerns(entry, alarm) for alarm in chosen)
    ]
    new = [_known(alarm, note, repaired) for alarm in chosen]
    write(_acknowledged(store), _json(Acknowledgements(schema=1, alarms=(*kept, *(() if undo else new)))))
    return chosen


def _alarm(event: Event, start: Sequence[float], reason: Cause) -> Alarm:
    """The alarm of an `event`. start: of the nights of the robot [days since 1970]."""
    change = event.change
    since = _date(start[change.index])
    days = start[event.segment[1] - 1] - start[change.index - 1]
    return Alarm(
        id=f"{event.robot}-{since.replace('-', '')}",
        robot=event.robot,
        since=since,
        since_ci95=(_date(start[change.first]), _date(start[change.last])),
        kind="growing" if change.growing else "sudden",
        per_day=float(change.size / days) if change.growing else None,
        shown_by=tuple(each.name for each in event.changes),
        log10_e=float(change.log_e / 2.302585),
        acknowledged=False,
        **dict(reason),
    )


def _with_acknowledgement(alarm: Alarm, known: Acknowledgements) -> Alarm:
    entry = next((entry for entry in known.alarms if _concerns(entry, alarm)), None)
    return alarm.model_copy(update={"acknowledged": entry is not None, "note": entry.note if entry else ""})


def _concerns(entry: Acknowledgement, alarm: Alarm) -> bool:
    """Whether the intervals of the date overlap: more nights date the same event a little differently."""
    (first, last), (begin, end) = entry.since_ci95, alarm.since_ci95
    return entry.robot == alarm.robot and first <= end and begin <= last


def _cause(store: Store, event: Event, of_robot: Nights, series: Sequence[Series], settings: FleetSettings) -> Cause:
    """The cause of an `event`; from the store, if the same recordings were diagnosed before."""
    keys = [[of_robot.keys[night] for night in nights] for nights in chosen_nights(event, of_robot)]
    path = store.folder / "causes" / f"{_digest([keys, settings.digest, event.change.growing, METHOD])}.json"
    known = _load(path, Cause)
    if known is not None:
        return known
    result = cause(event, of_robot, series, settings)
    write(path, _json(result))
    return result


def _digest(content: object) -> str:
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()


def _date(day: float) -> str:
    return str(moment(day).date())


def _fleet(store: Store) -> Path:
    return store.folder / "fleet.json"


def _acknowledged(store: Store) -> Path:
    return store.folder / "acknowledged.json"


def _acknowledgements(store: Store) -> Acknowledgements:
    return _load(_acknowledged(store), Acknowledgements) or Acknowledgements(schema=1)


def _load(path: Path, kind: type[_Content]) -> _Content | None:
    if not path.exists():
        return None
    content(path)  # a lost connection is no damage
    try:
        return validated(json_object(path, "file of the store"), kind, str(path))
    except BadInput as error:
        raise BadInput(f"{error}. Remove it, and run `ident fleet` again") from None


def _json(content: ConfigSection) -> bytes:
    return json.dumps(content.model_dump(mode="json", by_alias=True), indent=1).encode()
