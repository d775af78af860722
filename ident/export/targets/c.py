"""C99 for a controller: a folder with header, source, test vectors and an example."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ident.basics import slicing
from ident.basics.filters import contiguous_slices
from ident.export import c_source, tables, torque_table
from ident.export.c_source import CSettings as Settings
from ident.export.losses import Carried, sorted_by
from ident.export.paths import GivenPath, TorquePath
from ident.export.targets import ExportRequest
from ident.identification.model import Model
from recordings.errors import BadInput, told
from recordings.recording import Bools, Floats

__all__ = ["Settings", "carried_file", "write"]

TEST_ROWS = 1000
"""Number of test vectors."""


def write(request: ExportRequest) -> Carried:
    """See `Target`; the output is a folder."""
    carried, folder = carried_by(request.model), request.out
    settings = request.settings
    texts = c_source.files(request.model, carried.carried, request.precision, settings, request.digest)
    folder.mkdir(exist_ok=True)
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    rows = vectors(request.model, request.path, carried, settings)
    tables.load("csv")([rows], folder / "test_vectors.csv")
    return carried


def carried_file(out: Path) -> Path:
    """See `Target`."""
    return out / "carried.json"


def carried_by(model: Model) -> Carried:
    """Effects of `model` that C carries.

    Raises:
        BadInput: the model is one of Eqs. (37)-(40), which serve only for comparison.
    """
    if model.file.form:
        raise BadInput(
            f"a model of the mechanism expected, the form '{model.file.form}' found; fit with "
            + told("--method lad", 'method="lad"')
        )
    names = model.dynamics.structure.term_names
    reasons = {name: c_source.why_not(model.dynamics, index) for index, name in enumerate(names)}
    return sorted_by(model, {name: why for name, why in reasons.items() if why})


def vectors(model: Model, path: TorquePath, carried: Carried, settings: Settings) -> dict[str, Floats]:
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
        replace(motion, direction=settings.direction(motion.velocity)),
        temperature if c_source.needs_temperature(model) else None,
    )
    (table,) = torque_table.tables(model, stepped, torque_table.TorqueSummary())
    for joint in range(1, len(model.file.joints) + 1):
        for name in carried.lost:
            table[f"torque_{joint}"] = table[f"torque_{joint}"] - table.pop(f"{name}_{joint}")
    return table
