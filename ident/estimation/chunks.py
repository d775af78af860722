"""A model on a long recording, a stretch at a time: all of its columns at full rate would not fit into memory."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from ident.data.dataset import Dataset
from ident.data.prepared_recording import PreparedRecording, CorrectedMotion
from ident.dynamics.structure import ModelStructure
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats

CHUNK_LENGTH = 40_000
"""Instants that are looked at together."""
RUN_IN = 5.0
"""Seconds before a stretch after which effects with a memory are as if they had seen all that went before."""

_T = TypeVar("_T")


def torque(course: PreparedRecording, composition: ModelStructure, x: Floats) -> Floats:
    """What `ident.estimation.predicted_torque.Evaluator.torque` gives (m, dof) [N m]."""
    return np.concatenate([TorquePredictor(part).torque(composition, x)[own] for part, own in overlapping_chunks(course)])


def linearized(course: PreparedRecording, composition: ModelStructure, x: Floats) -> tuple[Floats, Floats]:
    """The same torque (m, dof), and its derivatives by the linear parameters (m, dof, K_linear)."""
    rows, dof = course.dataset.torque.shape
    computed, derivatives = np.empty((rows, dof)), np.empty((rows, dof, int(composition.linear.sum())))
    first = 0
    for part, own in overlapping_chunks(course):
        torque, by_x = TorquePredictor(part).linearized(composition, x, nonlinear=False)
        here = slice(first, first + len(torque[own]))
        computed[here], derivatives[here] = torque[own], by_x[own][:, :, composition.linear]
        first = here.stop
    return computed, derivatives


def overlapping_chunks(course: PreparedRecording) -> Iterator[tuple[PreparedRecording, slice]]:
    """`course` as it is, or parts of it that overlap, each with which of its rows are to be taken."""
    prepared = course.preprocessed
    n, step, reach = len(prepared.instants), prepared.decimation, prepared.half_width
    if reach is None or n <= CHUNK_LENGTH or n != len(course.samples.position):
        yield course, slice(None)
        return
    margin = -(-(reach + int(RUN_IN * course.samples.rate)) // step)
    size = CHUNK_LENGTH // step
    for first in range(0, -(-n // step), size):
        start = max(0, first - margin)
        rows = slice(start, first + size + margin)
        yield _part(course, rows, step), slice(first - start, first - start + size)


def _part(course: PreparedRecording, rows: slice, step: int) -> PreparedRecording:
    instants = slice(rows.start * step, rows.stop * step)
    prepared = course.preprocessed
    motion = _cut(course.as_recorded.motion, instants)
    return replace(
        course,
        samples=_cut(course.samples, instants),
        preprocessed=replace(
            prepared,
            motion=motion,
            instants=prepared.instants[instants],
            torque=prepared.torque[rows],
            sensitivity=prepared.sensitivity[rows],
        ),
        dataset=_rows(course.dataset, rows),
        as_recorded=CorrectedMotion(course.as_recorded.rig, motion, course.as_recorded.mechanism),
    )


def _rows(dataset: Dataset, rows: slice) -> Dataset:
    return replace(_cut(dataset, rows), motion=_cut(dataset.motion, rows))


def _cut(whole: _T, which: slice) -> _T:
    """`whole`, a dataclass, with all its arrays cut along time."""
    found: dict[str, Any] = {
        field.name: value[which]
        for field in fields(whole)  # type: ignore[arg-type]
        if isinstance(value := getattr(whole, field.name), np.ndarray)
    }
    return replace(whole, **found)  # type: ignore[type-var]
