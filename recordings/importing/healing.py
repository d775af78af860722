"""Mend samples: exclude and trim spans of time, unwrap angles, thin held samples, drop outliers."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from recordings.blocks import SampleTable
from recordings.errors import BadInput
from recordings.outliers import SIGNALS, without_outliers
from recordings.recording import Bools, Ints


@dataclass(frozen=True)
class TimeSpan:
    """Times from `start` to `end` [s], both included, counted from the first sample of the file."""

    start: float
    end: float

    def __str__(self) -> str:
        """As the options have it."""
        return f"{self.start!r}:{self.end!r}"

    def rows(self, samples: SampleTable, option: str, least: int = 1) -> Bools:
        """Mark the samples (n,) within: at `least` so many, and not all.

        Raises:
            BadInput: naming the `option`.
        """
        time = samples.stamp / 1e9
        rows: Bools = (time >= self.start) & (time <= self.end)
        if not least <= rows.sum() < len(rows):
            raise BadInput(
                f"{option}: some of the times from {time[0]:g} to {time[-1]:g} s expected, {self} found; correct it"
            )
        return rows


@dataclass(frozen=True)
class Healing:
    """What is mended: spans first, outliers and held samples last."""

    exclude: tuple[TimeSpan, ...] = ()
    """Times of which everything measured becomes a gap."""
    trim: TimeSpan | None = None
    """Times that are kept; of repetitions, those that are whole."""
    unwrap: tuple[int, ...] = ()
    """Joints, from 1, whose angles jump by whole turns."""
    thin: int = 1
    """Of every so many samples one is kept: where new values come."""
    drop_outliers: bool = False
    """Whether single samples far outside of all others become gaps."""

    def of(self, samples: SampleTable) -> SampleTable:
        """The mended `samples`.

        Raises:
            BadInput: there is no such joint or time, or hardly a sample is left.
        """
        for span in self.exclude:
            samples = _without(samples, span.rows(samples, "--exclude"))
        if self.trim:
            samples = _trimmed(samples, self.trim.rows(samples, "--trim", least=2))
        dof = samples.position.shape[1]
        if any(not 1 <= joint <= dof for joint in self.unwrap):
            raise BadInput(f"--unwrap: joints from 1 to {dof} expected, {self.unwrap} found; correct the list")
        for joint in self.unwrap:
            position = samples.position.copy()
            known = np.isfinite(position[:, joint - 1])
            position[known, joint - 1] = np.unwrap(position[known, joint - 1])
            samples = replace(samples, position=position)
        if 2 * self.thin > len(samples.stamp):
            most = len(samples.stamp) // 2
            raise BadInput(f"--thin: at most {most} expected, {self.thin} found; keep at least two samples")
        if self.drop_outliers:
            samples = without_outliers(samples)
        return samples if self.thin == 1 else _thinned(samples, self.thin)


def _thinned(samples: SampleTable, count: int) -> SampleTable:
    """Every `count`-th sample, from the one on at which most new values come."""
    changed = np.zeros(len(samples.stamp), bool)
    for name in SIGNALS:
        values = getattr(samples, name)
        if values is not None:
            changed[1:] |= (np.diff(values, axis=0) != 0).any(axis=1) & np.isfinite(values[1:]).any(axis=1)
    first = int(np.bincount(np.flatnonzero(changed) % count, minlength=count).argmax())
    return _rows(samples, np.arange(first, len(samples.stamp), count))


def _without(samples: SampleTable, rows: Bools) -> SampleTable:
    """The `samples` with gaps in `rows` (n,); what was commanded there, in one unbroken motion, stays."""
    measured = {name: getattr(samples, name) for name in (*SIGNALS, "velocity")}
    gaps: dict[str, Any] = {
        name: np.where(rows[:, None], np.nan, values) for name, values in measured.items() if values is not None
    }
    return replace(samples, **gaps)


def _trimmed(samples: SampleTable, rows: Bools) -> SampleTable:
    """Those of the `samples` in `rows` (n,); a repetition that is cut is none any more."""
    whole = np.setdiff1d(samples.repeat[rows], [-1, *samples.repeat[~rows]])
    numbers = np.where(np.isin(samples.repeat, whole), np.searchsorted(whole, samples.repeat), -1)
    return _rows(replace(samples, repeat=numbers), np.flatnonzero(rows))


def _rows(samples: SampleTable, rows: Ints) -> SampleTable:
    """The `samples` of these `rows` (m,), the first of which is at time 0."""
    chosen: dict[str, Any] = {
        field.name: value[rows]
        for field in fields(samples)
        if isinstance(value := getattr(samples, field.name), np.ndarray)
    }
    stamps: Ints = chosen["stamp"] - chosen["stamp"][0]
    extra = {name: values[rows] for name, values in samples.extra.items()}
    return replace(samples, **{**chosen, "stamp": stamps, "log": stamps, "extra": extra})
