"""One recording: read it, fit the base model, and describe both as rows of a table.

The fit is that of a diagnosis before its first effect: weighted least squares of the mechanism with the effects that
every such machine has. A whole diagnosis takes ten times as long, and is left for nights in which something changed
(docs/decisions/0014-fleet.md).
"""

import re
import warnings
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime, timedelta
from typing import Any

import numpy as np

from ident.basics.statistics import NORMAL
from ident.diagnosis.diagnosis import DiagnosisInputs, DiagnosisOptions, prepare_inputs
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.search import Search
from ident.diagnosis.split.split_data import rms
from ident.dynamics.effects.library import library
from ident.fleet.places import source
from ident.fleet.settings import FleetSettings
from ident.fleet.walk import RecordingFile
from recordings.errors import BadInput
from recordings.reader import Source, opened
from recordings.recording import Floats, Recording, Run

Row = dict[str, Any]
"""A row of the table; its columns are described in `ident.fleet.store`."""

_JOINT = re.compile(r"(\d+)$")
_TOMORROW = timedelta(days=1)
"""Clocks may be set to another time zone; a start later than this is no date."""


def examine(file: RecordingFile, settings: FleetSettings) -> list[Row]:
    """Rows of one recording: one of itself, and one for each parameter and each joint's error.

    A recording that cannot be used has one row, with the reason. Nothing is raised but what ends the whole program.
    """
    about = _about(file, settings)
    try:
        if not file.content:
            raise BadInput(f"{file.path} cannot be read; check its permissions")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            return _rows(about, source(file.path), settings)
    except MemoryError:
        return [failure(file, settings, "not enough memory for this recording", about)]
    except Exception as error:  # a damaged recording must not end the work on all others
        reason = str(error) if isinstance(error, BadInput) else f"{type(error).__name__}: {error}"
        return [failure(file, settings, reason, about)]


def failure(file: RecordingFile, settings: FleetSettings, reason: str, about: Row | None = None) -> Row:
    """The row of a `file` that is no usable recording; about: what is known of it all the same."""
    key = settings.key(file.content, str(file.path))
    return {**(about or _about(file, settings)), "key": key, "status": "failed", "reason": " ".join(reason.split())}


def _about(file: RecordingFile, settings: FleetSettings) -> Row:
    return {
        "key": settings.key(file.content),
        "settings": settings.digest,
        "content": file.content,
        "path": str(file.path),
        "size": file.size,
        "changed": file.changed,
        "kind": "recording",
        "name": "recording",
        "status": "done",
    }


def _rows(about: Row, found: Source, settings: FleetSettings) -> list[Row]:
    recording = opened(found)
    run = recording.run
    about["robot"] = run.robot or recording.rig.name
    temperature = _temperature(recording)
    about |= {
        "start": start_of(run),
        "simulated": run.simulated,
        "seconds": float(recording.time[-1]),
        "motion": motion_features(recording),
        "temperature": _mean(temperature),
    }
    _, model = base_fit([found], DiagnosisOptions(settings.preprocessing, settings.cutoff))
    values = [*_parameters(model), *_errors(model)]
    return [about, *({**about, **row, "temperature": _of_joint(temperature, row["joint"])} for row in values)]


def base_fit(sources: Sequence[Source], options: DiagnosisOptions) -> tuple[DiagnosisInputs, FittedModel]:
    """The recordings as a diagnosis prepares them, and the base model that is fitted to them.

    Raises:
        BadInput: one cannot be read, or they cannot be diagnosed together.
    """
    found = [each if isinstance(each, Recording) else source(each) for each in sources]
    inputs = prepare_inputs(found, [], library([]), options)
    search = Search(inputs.split, inputs.effects.observable, lambda text: None)
    return inputs, search.start(*inputs.initial_model(library([])))[0]


def start_of(run: Run) -> datetime:
    """The time at which a run began.

    Raises:
        BadInput: its clock was not set.
    """
    try:
        start = datetime.fromisoformat(run.start)
    except ValueError:
        raise BadInput(f"start: a time as 2026-01-05T08:00:00Z expected, '{run.start}' found") from None
    start = start if start.tzinfo else start.replace(tzinfo=UTC)
    if start.year <= 1970:
        raise BadInput(
            f"start: a date expected, {start.date()} found: the clock was not set, time was simulated, or "
            "the file that was imported does not tell it; give it to daq import by --start"
        )
    if start > datetime.now(UTC) + _TOMORROW:
        raise BadInput(f"start: a date of the past expected, {start.date()} found; the clock was wrong")
    return start.astimezone(UTC)


def motion_features(recording: Recording) -> list[float]:
    """Numbers by which the same motion is recognised: its period [s], and of each joint how far, how fast and how
    unevenly it moves [rad or m].

    They are blind to where a joint is: else a robot whose encoder has slipped would seem to move differently.
    """
    repeated = recording.repeat >= 0
    rows = repeated if repeated.any() else np.ones(len(repeated), bool)
    position, period = recording.position[rows], recording.run.period
    centred = position - np.nanmean(position, axis=0)
    speed = np.diff(centred, axis=0) / np.diff(recording.time[rows])[:, None] * (period or 1.0) / (2 * np.pi)
    moments = np.sqrt(np.nanmean(centred**2, axis=0)), np.sqrt(np.nanmean(speed**2, axis=0))
    return [period, *np.concatenate([*moments, np.cbrt(np.nanmean(centred**3, axis=0))]).tolist()]


def _temperature(recording: Recording) -> Floats:
    """(dof,) mean temperature of the drives [degC]; NaN where it was not measured."""
    temperature = recording.temperature
    known = np.isfinite(temperature)
    count = known.sum(axis=0)
    return np.where(count > 0, np.where(known, temperature, 0.0).sum(axis=0) / np.maximum(count, 1), np.nan)


def _mean(values: Floats) -> float | None:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else None


def _of_joint(temperature: Floats, joint: int | None) -> float | None:
    return _mean(temperature if joint is None else temperature[joint - 1 : joint])


def _parameters(model: FittedModel) -> Iterator[Row]:
    structure = model.solution.structure
    for entry, value, interval in zip(structure.parameters, model.solution.x, model.shape_intervals, strict=True):
        if not np.isfinite(interval).all():
            continue  # this motion does not show it
        number = _JOINT.search(entry.name)
        joint = int(number.group(1)) if number and int(number.group(1)) <= structure.rig.dof else None
        kind = "parameter" if entry.term < 0 else "effect"
        yield _value_row(kind, entry.name, joint, float(value), entry.unit, interval.tolist())


def _errors(model: FittedModel) -> Iterator[Row]:
    """The error of each joint; its interval is that of a mean square of so many independent rows."""
    split, rig = model.split, model.solution.structure.rig
    rows = split.scored
    spread = NORMAL / np.sqrt(2 * max(split.independent_rows / rig.dof, 1.0))
    pairs = zip(rms(model.residuals, rows), model.noise_floor.rms, rig.effort_units, strict=True)
    for joint, (error, floor, unit) in enumerate(pairs, start=1):
        interval = [float(error * (1 - spread)), float(error * (1 + spread))]
        yield _value_row("error", f"error_{joint}", joint, float(error), unit, interval)
        yield _value_row("floor", f"noise_floor_{joint}", joint, float(floor), unit, [None, None])


def _value_row(
    kind: str, name: str, joint: int | None, value: float, unit: str, interval: list[float] | list[None]
) -> Row:
    return {
        "kind": kind,
        "name": name,
        "joint": joint,
        "value": value,
        "unit": unit,
        "low": interval[0],
        "high": interval[1],
    }
