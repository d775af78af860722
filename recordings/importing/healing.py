"""Mend samples: unwrap angles, thin held samples, drop outliers."""

from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from recordings.blocks import SampleTable
from recordings.errors import BadInput
from recordings.outliers import without_outliers
from recordings.recording import Floats, Ints

_MEASURED = ("position", "voltage", "effort")
"""Signals in which outliers are looked for."""


@dataclass(frozen=True)
class Healing:
    """What is mended, in this order."""

    unwrap: tuple[int, ...] = ()
    """Joints, from 1, whose angles jump by whole turns."""
    thin: int = 1
    """Of every so many samples one is kept: where new values come."""
    drop_outliers: bool = False
    """Whether single samples far outside of all others become gaps."""

    def of(self, samples: SampleTable) -> SampleTable:
        """The mended `samples`.

        Raises:
            BadInput: there is no such joint.
        """
        dof = samples.position.shape[1]
        if any(not 1 <= joint <= dof for joint in self.unwrap):
            raise BadInput(f"--unwrap: joints from 1 to {dof} expected, {self.unwrap} found; correct the list")
        for joint in self.unwrap:
            samples = replace(samples, position=_unwrapped(samples.position, joint - 1))
        if self.drop_outliers:
            for name in _MEASURED:
                values = getattr(samples, name)
                samples = samples if values is None else _with(samples, name, without_outliers(values))
        return samples if self.thin == 1 else _thinned(samples, self.thin)


def _with(samples: SampleTable, name: str, values: Any) -> SampleTable:
    return replace(samples, **{name: values})


def _unwrapped(position: Floats, joint: int) -> Floats:
    result = position.copy()
    known = np.isfinite(position[:, joint])
    result[known, joint] = np.unwrap(position[known, joint])
    return result


def _thinned(samples: SampleTable, count: int) -> SampleTable:
    """Every `count`-th sample, from the one on at which most new values come."""
    changed = np.zeros(len(samples.stamp), bool)
    for name in _MEASURED:
        values = getattr(samples, name)
        if values is not None:
            changed[1:] |= (np.diff(values, axis=0) != 0).any(axis=1) & np.isfinite(values[1:]).any(axis=1)
    first = int(np.bincount(np.flatnonzero(changed) % count, minlength=count).argmax())
    rows = np.arange(first, len(samples.stamp), count)
    chosen: dict[str, Any] = {
        field.name: value[rows]
        for field in fields(samples)
        if isinstance(value := getattr(samples, field.name), np.ndarray)
    }
    stamps: Ints = chosen["stamp"] - chosen["stamp"][0]
    extra = {name: values[rows] for name, values in samples.extra.items()}
    return replace(samples, **{**chosen, "stamp": stamps, "log": stamps, "extra": extra})
