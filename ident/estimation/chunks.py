"""Evaluate a model on a long recording in chunks: all of its columns at full rate would not fit into memory."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.structure import ModelStructure
from ident.estimation.predicted_torque import TorquePredictor
from recordings.recording import Floats

CHUNK_LENGTH = 40_000
"""Instants per chunk."""
RUN_IN = 5.0
"""Run-in before a chunk after which the internal state of effects no longer depends on its initial value [s]."""


def torque(prepared: PreparedRecording, structure: ModelStructure, x: Floats) -> Floats:
    """Predict the torque (m, dof) [N m], as `ident.estimation.predicted_torque.TorquePredictor.torque`."""
    return np.concatenate(
        [TorquePredictor(chunk).torque(structure, x)[rows_used] for chunk, rows_used in overlapping_chunks(prepared)]
    )


def linearized(
    prepared: PreparedRecording, structure: ModelStructure, x: Floats, searched: bool = False
) -> tuple[Floats, Floats]:
    """Predict the torque (m, dof) and its derivatives (m, dof, k) by its linear, or its searched parameters."""
    m, dof = prepared.torque.shape
    which = structure.searched if searched else structure.linear
    predicted, derivatives = np.empty((m, dof)), np.empty((m, dof, int(which.sum())))
    first = 0
    for chunk, rows_used in overlapping_chunks(prepared):
        torque, by_x = TorquePredictor(chunk).linearized(structure, x, nonlinear=searched)
        chunk_rows = slice(first, first + len(torque[rows_used]))
        predicted[chunk_rows], derivatives[chunk_rows] = torque[rows_used], by_x[rows_used][:, :, which]
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
        yield _chunk(prepared, rows, step), slice(first - start, first - start + size)


def _chunk(prepared: PreparedRecording, rows: slice, step: int) -> PreparedRecording:
    instants = slice(rows.start * step, rows.stop * step)
    preprocessed = prepared.preprocessed
    return replace(
        prepared,
        samples=slicing.along_time(prepared.samples, instants),
        preprocessed=replace(
            preprocessed,
            motion=slicing.along_time(preprocessed.motion, instants),
            instants=preprocessed.instants[instants] - instants.start,
            torque=preprocessed.torque[rows],
            sensitivity=preprocessed.sensitivity[rows],
        ),
        regressor=prepared.regressor[rows],
        torque=prepared.torque[rows],
        start=prepared.start + instants.start / prepared.samples.rate,
        end=float(prepared.instant_time[-1]) if prepared.end is None else prepared.end,
    )
