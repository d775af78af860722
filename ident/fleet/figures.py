"""Drawings of the page of a fleet: robots over time at a glance, and the trends of one robot.

They are plain SVG, which a page of hundreds of robots holds without a library that is larger than it.
"""

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence

import numpy as np
from markupsafe import Markup

from delta_web.palette import CATEGORIES, JOINTS, MEASURED, NOISE
from ident.fleet.alarms import Alarm
from ident.fleet.change_screening import base_name
from ident.fleet.evidence import RobotEvidence
from ident.fleet.series import day_of_date, moment
from ident.fleet.thinned_series import Point, ThinnedSeries
from ident.output.digits import number
from recordings.recording import Floats

_WIDTH, _HEIGHT, _ROW = 900, 260, 26
"""Of the drawing of a quantity, and height of a robot at a glance [units of the drawing]."""
_LEFT, _RIGHT, _TOP, _BOTTOM = 120, 20, 48, 34
"""Margins for labels."""
_NIGHT = 6
"""Width of a single recording; those nearer to each other than this are one line."""
STATES = ("cannot be used", "as before", "changed, acknowledged", "changed")
_COLOURS = (MEASURED, NOISE, CATEGORIES[1], CATEGORIES[2])

Place = Callable[[Floats], Floats]
"""Where days are in a drawing."""


def glance(
    fleet: Mapping[str, RobotEvidence], failed: Sequence[tuple[str, float]], alarms: Sequence[Alarm]
) -> Markup:
    """Robots over time, coloured by their verdict. failed: robot and day of recordings, where these are known."""
    robots = sorted({*fleet, *(robot for robot, _ in failed)})
    days = [day for robot in fleet.values() for day in (robot.days[0], robot.days[-1])] + [day for _, day in failed]
    height = _TOP + _ROW * len(robots)
    if not days:
        return Markup()
    place = _scale(min(days), max(days), _LEFT, 2 * _WIDTH - _RIGHT)
    parts = [*_legend(dict(zip(STATES, _COLOURS, strict=True))), *_dates(min(days), max(days), place, height)]
    for index, robot in enumerate(robots):
        y = _TOP + _ROW * index + _ROW // 2
        parts.append(_text(0, y + 6, robot))
        known = np.array(fleet[robot].days if robot in fleet else [])
        unusable = np.array([day for name, day in failed if name == robot])
        state = _states(robot, known, alarms)
        nights = [unusable, *(known[state == value] for value in range(1, len(STATES)))]
        for of_state, colour in zip(nights, _COLOURS, strict=True):
            line = "".join(f"M{first} {y}H{last + _NIGHT}" for first, last in _runs(place(of_state)))
            parts.append(_path(line, colour, _ROW // 2))
    return _svg(2 * _WIDTH, height + _BOTTOM, parts)


def trends(
    of_robot: Mapping[str, ThinnedSeries], alarms: Sequence[Alarm], *, intervals: bool = False
) -> tuple[Markup, ...]:
    """Quantities of one robot over time, those of all joints in one drawing, with the dates of its `alarms`.

    intervals: draw those of 95 %, too.
    """
    groups: dict[str, list[ThinnedSeries]] = defaultdict(list)
    for name, trend in of_robot.items():
        groups["error" if trend.kind == "floor" else base_name(name).rstrip("_")].append(trend)
    return tuple(_trend(name, of_group, alarms, intervals=intervals) for name, of_group in groups.items())


def _trend(name: str, of_group: Sequence[ThinnedSeries], alarms: Sequence[Alarm], *, intervals: bool) -> Markup:
    points = np.array([point for trend in of_group for some in trend.points.values() for point in some])
    begin, end = float(points[:, 0].min()), float(points[:, 0].max())
    low, high = float((points[:, 1] - points[:, 2]).min()), float((points[:, 1] + points[:, 2]).max())
    x, y = _scale(begin, end, _LEFT, _WIDTH - _RIGHT), _scale(low, high, _TOP + _HEIGHT, _TOP)
    joints = {
        "whole robot" if each.joint is None else f"joint {each.joint}": _colour(each)
        for each in of_group
        if each.kind != "floor"
    }
    parts = [_text(0, 20, f"{name} [{of_group[0].unit}]"), *_legend(joints, 300)]
    parts += [_text(0, at + 6, number(value)) for value, at in ((low, _TOP + _HEIGHT), (high, _TOP))]
    parts += [*_dates(begin, end, x, _TOP + _HEIGHT)]
    parts += [part for alarm in alarms for part in _mark(alarm, x)]
    for trend in of_group:
        for motion, some in trend.points.items():
            parts += _dots(some, motion, x, y, _colour(trend), intervals=intervals)
    return _svg(_WIDTH, _TOP + _HEIGHT + _BOTTOM, parts)


def _colour(trend: ThinnedSeries) -> str:
    if trend.kind == "floor":
        return NOISE
    return CATEGORIES[0] if trend.joint is None else JOINTS[(trend.joint - 1) % len(JOINTS)]


def _dots(
    points: Sequence[Point], motion: int, x: Place, y: Place, colour: str, *, intervals: bool
) -> Iterator[Markup]:
    """Dots, squares for other motions than the first, and their intervals."""
    day, value, half, _ = np.array(points).T
    at, middle = np.rint(x(day)), np.rint(y(value))
    if intervals:
        low, high = np.rint(y(value - half)), np.rint(y(value + half))
        yield _path(_strokes(at, low, high), colour, 2)
    yield _path(_strokes(at, middle, middle), colour, 10, "square" if motion else "round")


def _strokes(x: Floats, begin: Floats, end: Floats) -> str:
    """Upright strokes from `begin` to `end`, dots where these are the same.

    Each place is relative to the last one, which takes fewer letters.
    """
    moves = np.diff(x, prepend=0), begin - np.r_[0.0, end[:-1]], end - begin
    return "".join(f"m{right:.0f} {down:.0f}v{length:.0f}" for right, down, length in zip(*moves, strict=True))


def _mark(alarm: Alarm, x: Place) -> Iterator[Markup]:
    """A line at the date of an alarm, and a band over its interval."""
    colour = CATEGORIES[1] if alarm.acknowledged else CATEGORIES[2]
    days = np.array([day_of_date(day) for day in (alarm.since, *alarm.since_ci95)])
    since, first, last = _integers(x(days))
    band = Markup('<rect x="{}" y="{}" width="{}" height="{}" fill="{}" opacity=".15"/>')
    yield band.format(first, _TOP, last - first, _HEIGHT, colour)
    yield _path(f"M{since} {_TOP}v{_HEIGHT}", colour, 2)


def _states(robot: str, days: Floats, alarms: Sequence[Alarm]) -> Floats:
    """(n,) index in STATES of the recordings of a `robot` in these `days`, which can be used."""
    state = np.ones(len(days))
    for alarm in alarms:
        if alarm.robot == robot:
            since = days >= day_of_date(alarm.since)
            state[since] = np.maximum(state[since], 2 if alarm.acknowledged else 3)
    return state


def _runs(x: Floats) -> list[tuple[int, int]]:
    """First and last place of recordings that are near to each other."""
    places = sorted(_integers(x))
    breaks = np.flatnonzero(np.diff(places) > _NIGHT) + 1
    return [(run[0], run[-1]) for run in np.split(np.array(places, int), breaks) if len(run)]


def _scale(low: float, high: float, begin: int, end: int) -> Place:
    width = high - low or 1.0
    return lambda value: begin + (value - low) / width * (end - begin)


def _dates(begin: float, end: float, place: Place, y: int) -> Iterator[Markup]:
    days = np.linspace(begin, end, 4)
    places = _integers(place(days))
    yield _path("".join(f"M{x} {y}v6" for x in places), MEASURED, 2)
    for day, x in zip(days.tolist(), places, strict=True):
        yield _text(x - 100, y + 28, str(moment(day).date()))


def _legend(colours: Mapping[str, str], begin: int = _LEFT) -> Iterator[Markup]:
    for index, (label, colour) in enumerate(colours.items()):
        x = begin + (280 if begin == _LEFT else 110) * index
        yield _path(f"M{x} 14h0", colour, 14, "round")
        yield _text(x + 12, 20, label)


def _text(x: int, y: int, text: str) -> Markup:
    return Markup('<text x="{}" y="{}">{}</text>').format(x, y, text)


def _path(line: str, colour: str, width: int, cap: str = "") -> Markup:
    ends = Markup(' stroke-linecap="{}"').format(cap) if cap else ""
    return Markup('<path d="{}" stroke="{}" stroke-width="{}"{}/>').format(line, colour, width, ends)


def _svg(width: int, height: int, parts: Sequence[Markup]) -> Markup:
    kind = "wide" if width > _WIDTH else "small"
    template = '<svg class="{}" viewBox="0 0 {} {}" font-size="20" fill="currentColor">{}</svg>'
    return Markup(template).format(kind, width, height, Markup().join(parts))


def _integers(values: Floats) -> list[int]:
    return np.rint(values).astype(int).tolist()
