"""Dates and times of day as seconds."""

import re
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats

_TIME_OF_DAY = re.compile(r"(\d{1,2}):(\d{2}):(\d{2}(?:[.,]\d+)?)")
_DAY_FIRST = re.compile(r"(\d{1,2})\.(\d{1,2})\.(\d{4})[ T](.*)")
_DATE = re.compile(r"\d{4}[-/]\d{2}[-/]\d{2}|\d{1,2}\.\d{1,2}\.\d{4}")
_DAY = 86400.0


def joined(texts: Mapping[str, Sequence[str]]) -> dict[str, Sequence[str]]:
    """Make one column of a column of dates and one of times of day among the cells of columns."""
    date, time = (
        next((name for name, cells in texts.items() if cells and all(map(kind.fullmatch, cells))), None)
        for kind in (_DATE, _TIME_OF_DAY)
    )
    if date is None or time is None:
        return dict(texts)
    cells = [
        f"{day} {of_day if of_day[2] == ':' else f'0{of_day}'}"
        for day, of_day in zip(texts[date], texts[time], strict=True)
    ]
    return {f"{date} {time}": cells, **{name: texts[name] for name in texts if name not in (date, time)}}


def seconds(cells: Sequence[str]) -> tuple[Floats, str | None] | None:
    """Seconds (n,) since the first of `cells`, and that date in ISO 8601; None if they are no dates.

    Known are ISO 8601 ("2026-01-05 08:00:00.125"), "05.01.2026 08:00:00,125", and times of day, which have no date.
    Without a zone they are taken for UTC.
    """
    if not cells:
        return None
    if all(_TIME_OF_DAY.fullmatch(cell) for cell in cells):
        return _times_of_day(cells), None
    try:
        stamps = [_parsed(cell) for cell in cells]
    except (ValueError, OverflowError):
        return None
    whole = np.array([(stamp - stamps[0]).total_seconds() for stamp in stamps])
    return whole, stamps[0].isoformat(timespec="milliseconds")


def iso_date(option: str, text: str) -> str:
    """Check a date in ISO 8601 that the user gives; returns it in UTC.

    Raises:
        BadInput: it is no date.
    """
    try:
        return _parsed(text).astimezone(UTC).isoformat(timespec="milliseconds")
    except (ValueError, OverflowError):
        raise BadInput(
            f"{option}: a date such as 2026-01-05T08:00:00Z expected, {text!r} found; correct it"
        ) from None


def _parsed(cell: str) -> datetime:
    if match := _DAY_FIRST.fullmatch(cell):
        day, month, year, time = match.groups()
        cell = f"{year}-{month:0>2}-{day:0>2} {time}"
    stamp = datetime.fromisoformat(cell.replace("/", "-"))
    if ":" not in cell:
        raise ValueError("a time of day expected")
    return stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)


def _times_of_day(cells: Sequence[str]) -> Floats:
    """Seconds (n,) since the first time of day; midnight may pass between two."""
    parts = [_TIME_OF_DAY.fullmatch(cell) for cell in cells]
    time = np.array([int(m[1]) * 3600 + int(m[2]) * 60 + float(m[3].replace(",", ".")) for m in parts if m])
    days = np.concatenate([[0.0], np.cumsum(np.diff(time) < -_DAY / 2)])
    return time + days * _DAY - time[0]
