"""What the whole fleet does together: a season, where nobody measured temperatures."""

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ident.fleet.series import Series
from recordings.recording import Floats

MIN_OTHERS = 4
"""Other robots whose median is the course of the fleet."""
SAME_NIGHT = 1.5
"""Recordings within so many days are of the same night [days]."""


def with_common_course(series: Sequence[Series]) -> list[Series]:
    """The `series`, each without measured temperatures beside what the same quantity of the other robots did."""
    by_name: dict[str, list[Series]] = defaultdict(list)
    for each in series:
        by_name[each.name].append(each)
    return [each if np.isfinite(each.temperature).any() else _beside(each, by_name[each.name]) for each in series]


def _beside(series: Series, of_name: Sequence[Series]) -> Series:
    others = [_deviations(other, series.nights.day) for other in of_name if other.nights is not series.nights]
    if len(others) < MIN_OTHERS:
        return series
    deviations = np.array(others)
    count = np.isfinite(deviations).sum(axis=0)
    if (count[series.known] < MIN_OTHERS).any():  # robots that joined later
        return series
    common = np.zeros(len(count))
    common[count > 0] = np.nanmedian(deviations[:, count > 0], axis=0)
    return replace(series, common=common)


def _deviations(series: Series, day: Floats) -> Floats:
    """(n,) relative deviation of a series from its median in the recording nearest to each `day`; NaN: none near."""
    known = np.flatnonzero(series.known)
    if not len(known):
        return np.full(len(day), np.nan)
    relative = series.value.copy()
    for motion in np.unique(series.nights.motion[known]):
        rows = known[series.nights.motion[known] == motion]
        centre = np.median(series.value[rows])
        relative[rows] = (series.value[rows] - centre) / (abs(centre) or 1.0)
    nearest = known[np.abs(series.nights.day[known][None, :] - day[:, None]).argmin(axis=1)]
    near = np.abs(series.nights.day[nearest] - day) <= SAME_NIGHT
    return np.where(near, relative[nearest], np.nan)
