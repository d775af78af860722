"""Parameters that are followed by recursive least squares with forgetting, with intervals; others stay as fitted."""

from collections.abc import Sequence

import numpy as np

from ident.basics.statistics import NORMAL, TINY
from ident.dynamics.structure import ModelStructure
from ident.identification.model_file import ModelFile
from ident.watch.blocks import Rows
from recordings.errors import BadInput, did_you_mean
from recordings.recording import Floats, Ints

MEMORY = 20.0
"""Time after which a row counts for 1/e [s]: several cycles, so that all parts of a motion are in it."""


def tracked_entries(structure: ModelStructure, names: Sequence[str]) -> Ints:
    """(k,) indices of the parameters `names` among the linear ones.

    Raises:
        BadInput: there is no such parameter, or the torque is not linear in it.
    """
    known = [entry.name for entry in structure.parameters if entry.linear]
    for name in names:
        if name not in known:
            raise BadInput(
                f"--track: linear parameters of the model expected ({', '.join(known)}), {name} found;"
                f"{did_you_mean(name, known) or ' choose among them'}"
            )
    return np.array([known.index(name) for name in names], np.int64)


class ParameterTracker:
    """Estimates of the followed parameters (k,): as fitted at first, then as the last rows show them."""

    def __init__(self, model: ModelFile, names: Sequence[str]) -> None:
        self._names = names
        fitted = {parameter.name: parameter for parameter in model.parameters}
        self._fitted: Floats = np.array([fitted[name].value for name in names])
        limits = [fitted[name].ci95 for name in names]
        std = np.array([np.inf if each is None else (each[1] - each[0]) / (2 * NORMAL) for each in limits])
        self._information = np.diag(1 / np.maximum(std, TINY) ** 2)
        self._weighted: Floats = np.zeros(len(names))
        self._bandwidth = model.preprocessing.bandwidth

    def update(self, rows: Rows, columns: Floats) -> None:
        """Take the rows of a second; columns: (m, dof, k) derivatives of the torque by the parameters."""
        counted = rows.counted & np.isfinite(rows.residual)
        if counted.sum() <= len(self._names):
            return
        rate = 1 / float(np.diff(rows.time).mean())
        # Filtered rows resemble each other: so many of them are worth one.
        share = min(1.0, 2 * self._bandwidth / rate)
        forgetting = np.exp(-len(rows.time) / rate / MEMORY)
        self._information, self._weighted = forgetting * self._information, forgetting * self._weighted
        for joint in range(counted.shape[1]):
            used = counted[:, joint]
            x, y = columns[used, joint], rows.residual[used, joint]
            rest = y - x @ np.linalg.lstsq(x, y, rcond=None)[0] if len(y) else y
            weight = share / max(float(np.mean(rest**2)), TINY) if len(y) else 0.0
            self._information = self._information + weight * x.T @ x
            self._weighted = self._weighted + weight * x.T @ y

    def as_json(self) -> dict[str, dict[str, object]]:
        """Value and interval of each parameter; null while nothing tells them."""
        if np.linalg.matrix_rank(self._information, hermitian=True) < len(self._names):
            return {name: {"value": None, "ci95": None} for name in self._names}
        covariance = np.linalg.inv(self._information)
        value, half = self._fitted + covariance @ self._weighted, NORMAL * np.sqrt(np.diag(covariance))
        return {
            name: {"value": float(at), "ci95": [float(at - width), float(at + width)]}
            for name, at, width in zip(self._names, value, half, strict=True)
        }
