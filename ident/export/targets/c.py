"""C99 for a controller: a folder with header, source, test vectors and an example."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.basics import slicing
from ident.basics.filters import contiguous_slices
from ident.export import c_source, tables, torque_table
from ident.export.losses import Carried, sorted_by
from ident.export.paths import GivenPath, TorquePath
from ident.export.targets import ExportRequest
from ident.identification.model import Model
from recordings.errors import BadInput
from recordings.recording import Bools, Floats

TEST_ROWS = 1000
"""Number of test vectors."""


def write(request: ExportRequest) -> Carried:
    """See `Target`; the output is a folder."""
    carried, folder = carried_by(request.model), request.out
    folder.mkdir(exist_ok=True)
    for name, text in c_source.files(request.model, indices(request.model, carried), request.precision).items():
        (folder / name).write_text(text, encoding="utf-8")
    tables.load("csv")([vectors(request.model, request.path, carried)], folder / "test_vectors.csv")
    return carried


def carried_file(out: Path) -> Path:
    """See `Target`."""
    return out / "carried.json"


def carried_by(model: Model) -> Carried:
    """Effects of `model` that C carries.

    Raises:
        BadInput: the model is one of Eqs. (37)-(40), which serve only for comparison, or one of a URDF.
    """
    if model.file.robot is not None:
        raise BadInput(
            "a model of the mechanism 'delta' or 'axes' expected for C, 'urdf' found, for which no C is written yet; "
            "export --to csv, or compute the torque by ident torque"
        )
    if model.file.form:
        raise BadInput(
            f"a model of the mechanism expected, the form '{model.file.form}' found; fit with --method lad"
        )
    names = model.dynamics.structure.term_names
    reasons = {name: c_source.why_not(model.dynamics, index) for index, name in enumerate(names)}
    return sorted_by(model, {name: why for name, why in reasons.items() if why})


def indices(model: Model, carried: Carried) -> frozenset[int]:
    """Indices of the terms that are carried."""
    names = model.dynamics.structure.term_names
    return frozenset(index for index, name in enumerate(names) if name in carried.carried)


def vectors(model: Model, path: TorquePath, carried: Carried) -> dict[str, Floats]:
    """Columns of the table of torques for the first known rows of `path`: what a controller gets, step by step."""
    chunk = next(path.chunks())
    known: Bools = np.asarray(np.isfinite(chunk.motion.acceleration).all(axis=1))
    rows = contiguous_slices(known)[0]
    rows = slice(rows.start, min(rows.stop, rows.start + TEST_ROWS))
    motion = slicing.along_time(chunk.motion, rows)
    temperature = np.full_like(motion.position, c_source.TEMPERATURE)
    stepped = GivenPath(
        path.name,
        path.rate,
        np.arange(len(motion.position)) / path.rate,
        replace(motion, direction=np.sign(motion.velocity)),
        temperature if c_source.needs_temperature(model) else None,
    )
    (table,) = torque_table.tables(model, stepped, torque_table.TorqueSummary())
    for joint in range(1, len(model.file.joints) + 1):
        for name in carried.lost:
            table[f"torque_{joint}"] = table[f"torque_{joint}"] - table.pop(f"{name}_{joint}")
    return table
