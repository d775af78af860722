"""The alarms of a fleet: what changed on which robot since when, and whether somebody knows of it.

`STORE/fleet.json` holds the last result, `STORE/acknowledged.json` what was acknowledged, and `STORE/causes/` the
diagnoses of events, which are made once for the same recordings.
"""

import hashlib
import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Literal, TypeVar

import pyarrow as pa
import pyarrow.compute as pc
from pydantic import Field

from ident.fleet.cause import METHOD, Cause, Origin, Verdict, cause, chosen_nights
from ident.fleet.discoveries import Event, events
from ident.fleet.series import Nights, Series, moment, nights_and_series
from ident.fleet.settings import FleetSettings
from ident.fleet.store import Store
from recordings.config import ConfigSection, validated
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.limits import json_object

_Content = TypeVar("_Content", bound=ConfigSection)


class Alarm(ConfigSection):
    """One alarm, as `ident fleet --json` prints it."""

    id: str
    """By which it is acknowledged."""
    robot: str
    effect: str | None
    """None if it is unknown."""
    confusable_with: tuple[str, ...]
    joints: tuple[int, ...]
    since: str
    """Date of the first recording with it (UTC)."""
    since_ci95: tuple[str, str]
    kind: Literal["sudden", "growing"]
    verdict: Verdict
    origin: Origin
    depends_on: tuple[str, ...]
    per_day: float | None
    """Of the quantity that shows it best: change per day of one that grows, in its unit or relative."""
    shown_by: tuple[str, ...]
    """Quantities that changed, the clearest first."""
    log10_e: float
    """Decimal logarithm of the e-value."""
    explained: float
    torque_share: float
    before: tuple[str, ...]
    """Recordings that were diagnosed together."""
    after: tuple[str, ...]
    why: str
    acknowledged: bool
    note: str = ""


class Acknowledgement(ConfigSection):
    """An alarm that somebody knows of."""

    robot: str
    since_ci95: tuple[str, str]
    note: str = ""


class Acknowledgements(ConfigSection):
    """Content of `acknowledged.json`."""

    schema_version: Literal[1] = Field(1, alias="schema")
    alarms: tuple[Acknowledgement, ...] = ()


class FleetFile(ConfigSection):
    """Content of `fleet.json`."""

    schema_version: Literal[1] = Field(1, alias="schema")
    settings: str
    """Digest of the settings and the method of the last run."""
    folders: tuple[str, ...]
    recordings: dict[str, int]
    alarms: tuple[Alarm, ...]


def find(
    store: Store, settings: FleetSettings, progress: Callable[[int, int], None] = lambda done, total: None
) -> list[Alarm]:
    """The alarms of the recordings in the `store` that were analysed with these `settings`."""
    _, series = watched(store, settings.digest)
    fleet_events = events(series)
    acknowledged = _acknowledgements(store)
    alarms = []
    for done, event in enumerate(fleet_events):
        progress(done, len(fleet_events))
        of_robot = [each for each in series if each.nights is event.nights]
        alarms.append(_alarm(event, _cause(store, event, of_robot, settings), acknowledged))
    return alarms


def watched(store: Store, settings: str) -> tuple[list[Nights], list[Series]]:
    """Nights and series of all robots, of the rows with this digest of `settings`."""
    table: pa.Table = store.table()
    return nights_and_series(table.filter(pc.equal(table["settings"], settings)))


def save(store: Store, content: FleetFile) -> None:
    """Write `fleet.json`."""
    _write(_fleet(store), content)


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


def acknowledge(store: Store, ids: Sequence[str], note: str, undo: bool = False) -> list[Alarm]:
    """Acknowledge alarms, or take that back; return those concerned.

    Raises:
        BadInput: there is no such alarm.
    """
    alarms = {alarm.id: alarm for alarm in load(store).alarms}
    for identity in ids:
        if identity not in alarms:
            listing = ", ".join(alarms) or "none"
            raise BadInput(f"an alarm of this store expected ({listing}), '{identity}' found; choose one of them")
    chosen = [alarms[identity] for identity in ids]
    kept = [
        entry for entry in _acknowledgements(store).alarms if not any(_concerns(entry, alarm) for alarm in chosen)
    ]
    new = [Acknowledgement(robot=alarm.robot, since_ci95=alarm.since_ci95, note=note) for alarm in chosen]
    _write(_acknowledged(store), Acknowledgements(schema=1, alarms=(*kept, *(() if undo else new))))
    return chosen


def _alarm(event: Event, reason: Cause, acknowledged: Acknowledgements) -> Alarm:
    change, nights = event.change, event.nights
    since = _date(nights, change.index)
    days = nights.day[event.segment[1] - 1] - nights.day[change.index - 1]
    alarm = Alarm(
        id=f"{nights.robot}-{since.replace('-', '')}",
        robot=nights.robot,
        effect=reason.effect,
        confusable_with=reason.confusable_with,
        joints=reason.joints,
        since=since,
        since_ci95=(_date(nights, change.first), _date(nights, change.last)),
        kind="growing" if change.growing else "sudden",
        verdict=reason.verdict,
        origin=reason.origin,
        depends_on=reason.depends_on,
        per_day=float(change.size / days) if change.growing else None,
        shown_by=tuple(each.series.name for each in event.changes),
        log10_e=float(change.log_e / 2.302585),
        explained=reason.explained,
        torque_share=reason.torque_share,
        before=reason.before,
        after=reason.after,
        why=reason.why,
        acknowledged=False,
    )
    return _with_acknowledgement(alarm, acknowledged)


def _with_acknowledgement(alarm: Alarm, known: Acknowledgements) -> Alarm:
    entry = next((entry for entry in known.alarms if _concerns(entry, alarm)), None)
    return alarm.model_copy(update={"acknowledged": entry is not None, "note": entry.note if entry else ""})


def _concerns(entry: Acknowledgement, alarm: Alarm) -> bool:
    """Whether the intervals of the date overlap: more nights date the same event a little differently."""
    (first, last), (begin, end) = entry.since_ci95, alarm.since_ci95
    return entry.robot == alarm.robot and first <= end and begin <= last


def _cause(store: Store, event: Event, series: Sequence[Series], settings: FleetSettings) -> Cause:
    """The cause of an `event`; from the store, if the same recordings were diagnosed before."""
    before, after = chosen_nights(event)
    keys = [[event.nights.keys[night] for night in nights] for nights in (before, after)]
    identity = json.dumps([keys, settings.digest, event.change.growing, METHOD])
    path = store.folder / "causes" / f"{hashlib.sha256(identity.encode()).hexdigest()}.json"
    known = _load(path, Cause)
    if known is not None:
        return known
    result = cause(event, series, settings)
    path.parent.mkdir(exist_ok=True)
    _write(path, result)
    return result


def _date(nights: Nights, night: int) -> str:
    return str(moment(nights.day[night]).date())


def _fleet(store: Store) -> Path:
    return store.folder / "fleet.json"


def _acknowledged(store: Store) -> Path:
    return store.folder / "acknowledged.json"


def _acknowledgements(store: Store) -> Acknowledgements:
    return _load(_acknowledged(store), Acknowledgements) or Acknowledgements(schema=1)


def _load(path: Path, kind: type[_Content]) -> _Content | None:
    if not path.exists():
        return None
    try:
        return validated(json_object(path, "file of the store"), kind, str(path))
    except BadInput as error:
        raise BadInput(f"{error}. Remove it, and run `ident fleet` again") from None


def _write(path: Path, content: ConfigSection) -> None:
    try:
        with replacement(path) as partial:
            partial.write_text(json.dumps(content.model_dump(mode="json", by_alias=True), indent=1), encoding="utf-8")
    except OSError as error:
        raise BadInput(f"{path} cannot be written: {error.strerror}; make room, and run again") from None
