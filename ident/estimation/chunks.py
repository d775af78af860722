"""Evaluate a model on a long recording in chunks: all of its columns at full rate would not fit into memory."""

from collections.abc import Iterator
from dataclasses import fields, replace
from typing import Any, TypeVar

import numpy as np

from ident.data.dataset import Dataset
from ident.data.prepared_recording import CorrectedMotion, PreparedRecording
from ident.dynamics.structure import ModelStructure
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats

CHUNK_LENGTH = 40_000
"""Instants per chunk."""
RUN_IN = 5.0
"""Run-in before a chunk after which the internal state of effects no longer depends on its initial value [s]."""

_T = TypeVar("_T")


def torque(prepared: PreparedRecording, structure: ModelStructure, x: Floats) -> Floats:
    """Predict the torque (m, dof) [N m], as `ident.estimation.predicted_torque.TorquePredictor.torque`."""
    return np.concatenate(
        [TorquePredictor(chunk).torque(structure, x)[rows_used] for chunk, rows_used in overlapping_chunks(prepared)]
    )


def linearized(prepared: PreparedRecording, structure: ModelStructure, x: Floats) -> tuple[Floats, Floats]:
    """Predict the torque (m, dof) and its derivatives with respect to the linear parameters (m, dof, K_linear)."""
    m, dof = prepared.dataset.torque.shape
    predicted, derivatives = np.empty((m, dof)), np.empty((m, dof, int(structure.linear.sum())))
    first = 0
    for chunk, rows_used in overlapping_chunks(prepared):
        torque, by_x = TorquePredictor(chunk).linearized(structure, x, nonlinear=False)
        chunk_rows = slice(first, first + len(torque[rows_used]))
        predicted[chunk_rows], derivatives[chunk_rows] = torque[rows_used], by_x[rows_used][:, :, structure.linear]
        first = chunk_rows.stop
    return predicted, derivatives


def overlapping_chunks(prepared: PreparedRecording) -> Iterator[tuple[PreparedRecording, slice]]:
    """Yield `prepared` itself, or overlapping chunks of it, each with the slice of its rows to use."""
    preprocessed = prepared.preprocessed
    n, step, half_width = len(preprocessed.instants), preprocessed.decimation, preprocessed.half_width
    if half_width is None or n <= CHUNK_LENGTH or n != len(prepared.samples.position):
        yield prepared, slice(None)
        return
    margin = -(-(half_width + int(RUN_IN * prepared.samples.rate)) // step)
    size = CHUNK_LENGTH // step
    for first in range(0, -(-n // step), size):
        start = max(0, first - margin)
        rows = slice(start, first + size + margin)
        yield _cut_recording(prepared, rows, step), slice(first - start, first - start + size)


def _cut_recording(prepared: PreparedRecording, rows: slice, step: int) -> PreparedRecording:
    instants = slice(rows.start * step, rows.stop * step)
    preprocessed = prepared.preprocessed
    motion = _cut(prepared.as_recorded.motion, instants)
    return replace(
        prepared,
        samples=_cut(prepared.samples, instants),
        preprocessed=replace(
            preprocessed,
            motion=motion,
            instants=preprocessed.instants[instants],
            torque=preprocessed.torque[rows],
            sensitivity=preprocessed.sensitivity[rows],
        ),
        dataset=_cut_dataset(prepared.dataset, rows),
        as_recorded=CorrectedMotion(prepared.as_recorded.rig, motion, prepared.as_recorded.mechanism),
    )


def _cut_dataset(dataset: Dataset, rows: slice) -> Dataset:
    return replace(_cut(dataset, rows), motion=_cut(dataset.motion, rows))


def _cut(data: _T, index: slice) -> _T:
    """Cut all arrays of the dataclass `data` along time."""
    arrays: dict[str, Any] = {
        field.name: value[index]
        for field in fields(data)  # type: ignore[arg-type]
        if isinstance(value := getattr(data, field.name), np.ndarray)
    }
    return replace(data, **arrays)  # type: ignore[type-var]
