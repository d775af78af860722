"""Watch a recording, line by line: residual, alarm, and what a diagnosis of before and after says."""

from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ident.basics import slicing
from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.fleet.cause import Cause, cause_between
from ident.identification.model import Model
from ident.identification.prediction import predict
from ident.watch.baseline import Baseline, baseline, is_same_motion
from ident.watch.monitor import Monitor, ResidualChange
from ident.watch.residual_follower import ResidualFollower, Second
from ident.watch.tracking import ParameterTracker
from recordings.errors import BadInput
from recordings.reader import Source, opened
from recordings.recording import Floats, Recording

WINDOW = 12.0
"""Seconds of the recording that are diagnosed before a change, and after it, at most."""
_LEAST = 4.0
"""Seconds of motion in such a window, at least."""
_ROUNDING = 1e-9
_KEPT = 4 * WINDOW
"""Seconds that are kept for it."""


class Watch:
    """Follows one recording; `lines` are documents for JSON."""

    def __init__(
        self, model: Model, healthy: Sequence[Source], samples: float | None = None, track: Sequence[str] = ()
    ) -> None:
        """`samples` per second for a live view [Hz]; None: none. `track`: names of parameters that are followed."""
        self._model, self._healthy, self._samples, self._track = model, healthy, samples, track
        self._follower = ResidualFollower(model, samples is not None, track)
        self._tracker: ParameterTracker | None = None
        self._monitor: Monitor | None = None
        self._pieces: deque[Recording] = deque()
        self.alarmed = False
        """Whether the alarm was told."""
        test = model.file.residual_test
        self._floor = list(test.noise_rms) if test else [None] * len(model.file.joints)

    def lines(self, pieces: Iterable[Recording]) -> Iterator[dict[str, Any]]:
        """Yield a line for each second, and one for the alarm.

        Raises:
            BadInput: the recording is of another rig than the model, nothing of it is usable, or no healthy recording
                has its motion.
        """
        for piece in pieces:
            if self._monitor is None:
                self._monitor = Monitor(self._baseline(piece))
            self._pieces.append(piece)
            for second in self._follower.seconds(piece):
                yield from self._lines(second)
            while piece.time[-1] - self._pieces[0].time[-1] > _KEPT:
                self._pieces.popleft()
        for second in self._follower.last():
            yield from self._lines(second)
        yield from self._alarm(np.inf)

    def _baseline(self, piece: Recording) -> Baseline:
        if not piece.run.period:
            raise BadInput(
                f"{piece.path.name}: a motion that repeats expected, so that it can be compared with healthy "
                "recordings of it, none found; give its cycles (column 'cycle' of an imported recording)"
            )
        return baseline(predict(self._model.file, self._healthy, self._model.library), piece.run.period)

    def _lines(self, second: Second) -> Iterator[dict[str, Any]]:
        assert self._monitor is not None
        line: dict[str, Any] = {"time": round(second.time, 6), "delay": round(self._follower.delay, 4)}
        line |= {"residual_rms": [None] * len(self._floor), "floor_rms": self._floor, "alarm": None}
        if second.rows is not None:
            line["residual_rms"] = _numbers(_rms(second.rows.residual))
            self._monitor.observe(second.rows)
            if second.columns is not None:
                self._tracker = self._tracker or ParameterTracker(self._model.file, self._track)
                self._tracker.update(second.rows, second.columns)
            if self._samples is not None:
                line["samples"] = _samples(second, self._samples)
        if self._tracker is not None:
            line["parameters"] = self._tracker.as_json()
        yield line
        yield from self._alarm(second.time)

    def _alarm(self, now: float) -> Iterator[dict[str, Any]]:
        """Yield the alarm once the window behind it is complete, or at the end of the recording."""
        assert self._monitor is not None
        raised = self._monitor.alarmed
        if self.alarmed or raised is None or now < raised + WINDOW / 2:
            return
        self.alarmed = True
        change = self._monitor.change()
        cause = self._cause(change)
        told = {
            "joints": [joint + 1 for joint in change.joints],
            "since": round(change.since, 3),
            "kind": change.kind,
        }
        told |= {"effect": None, "confusable_with": [], "evidence": change.evidence}
        if cause is not None and cause.effect:
            told |= {"joints": [*cause.joints], "effect": cause.effect, "confusable_with": [*cause.confusable_with]}
        yield {"time": round(min(now, float(self._pieces[-1].time[-1])), 6), "alarm": told}

    def _cause(self, change: ResidualChange) -> Cause | None:
        """What a diagnosis says; None: the recording ended too soon after the change."""
        settings = self._model.file.preprocessing
        whole = slicing.concatenated(list(self._pieces))
        end = float(whole.time[-1])
        after = _window(whole, max(change.since, end - WINDOW), end, "after")
        before = _window(whole, change.since - WINDOW, change.since, "before")
        if before is None:  # it was there from the beginning
            before = self._healthy_window(whole.run.period)
        if before is None or after is None:
            return None
        joints = tuple(joint + 1 for joint in change.joints)
        options = DiagnosisOptions(settings.name, settings.bandwidth)
        return cause_between(
            [before],
            [after],
            joints,
            options,
            lambda names: np.zeros((2, len(names))),
            growing=change.kind == "growing",
        )

    def _healthy_window(self, period: float) -> Recording | None:
        """The beginning of a healthy recording of the motion with this `period` [s]."""
        for source in self._healthy:
            healthy = opened(source)
            if is_same_motion(healthy, period):
                first = float(healthy.time[healthy.repeat >= 0][0])
                return _window(healthy, first, first + WINDOW, "before")
        return None


def _window(recording: Recording, first: float, end: float, name: str) -> Recording | None:
    """The cycles between two times [s], as a recording of its own; None: too few samples."""
    inside = (recording.time >= first) & (recording.time < end) & (recording.repeat >= 0)
    if inside.sum() < _LEAST * recording.run.rate:
        return None
    cut = slicing.along_time(recording, inside)
    time = cut.time - cut.time[0]
    repeat = (time / cut.run.period + _ROUNDING).astype(np.int64)  # cycles that begin with the window
    return replace(cut, time=time, repeat=repeat, events=(), known_digest=f"{name} {cut.time[0]:g}")


def _rms(residual: Floats) -> Floats:
    known = np.isfinite(residual)
    square = np.where(known, residual, 0.0) ** 2
    mean: Floats = np.where(known.any(axis=0), square.sum(axis=0) / np.maximum(known.sum(axis=0), 1), np.nan)
    return np.sqrt(mean)


def _samples(second: Second, rate: float) -> dict[str, Any]:
    """What a live view draws of a second, at no more than `rate` [Hz]."""
    rows = second.rows
    assert rows is not None
    step = 1 if len(rows.time) < 2 else max(1, round(1 / (rate * float(np.diff(rows.time).mean()))))
    thinned = slicing.along_time(rows, slice(None, None, step))
    return {
        "time": thinned.time.round(6).tolist(),
        "measured": _table(thinned.measured),
        "model": _table(thinned.measured - thinned.residual),
        "residual": _table(thinned.residual),
        "terms": {name: _table(values[::step]) for name, values in second.terms.items()},
    }


def _table(values: Floats) -> list[list[float | None]]:
    return [_numbers(row) for row in values]


def _numbers(values: Floats) -> list[float | None]:
    """Values with six digits; None where they are not known."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]
