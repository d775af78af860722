"""A model from a file, applied to recordings: what it says the torque should have been."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ident import effects, mechanisms
from ident.dataset import Dataset, build
from ident.mechanisms import Mechanism
from ident.model import Model
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording
from recordings.rig import Geometry, Torque


@dataclass(frozen=True, eq=False)
class Prediction:
    """One recording, preprocessed as the model's own were, and the torque that the model computes for it."""

    dataset: Dataset
    computed: Floats
    """(m, dof) [N m or N]."""

    @property
    def residual(self) -> Floats:
        """(m, dof) measured minus computed; NaN where a sample is not to be used."""
        left: Floats = self.dataset.torque - self.computed
        return left


def predict(model: Model, files: Sequence[Path]) -> tuple[Prediction, ...]:
    """Apply `model` to the recordings `files`.

    Raises:
        BadInput: a recording cannot be used, or is of another rig than the model.
    """
    recordings = [read(path) for path in files]
    for recording in recordings:
        refuse_other_rig(model, recording)
    mechanism = mechanism_of(model, recordings[0])
    values = np.array([parameter.value for parameter in model.parameters])
    cutoff = model.preprocessing.bandwidth if model.preprocessing.cutoff else None
    datasets = [build(recording, mechanism, model.preprocessing.name, cutoff) for recording in recordings]
    return tuple(Prediction(dataset, dataset.regressor @ values) for dataset in datasets)


def mechanism_of(model: Model, recording: Recording) -> Mechanism:
    """The mechanism, with its effects, whose parameters `model` holds.

    Raises:
        BadInput: the model holds other parameters than this software knows.
    """
    rig = recording.rig
    mechanism = effects.with_effects(mechanisms.create(rig, model.form), model.effects, rig)
    expected = [parameter.name for parameter in mechanism.parameters]
    found = [parameter.name for parameter in model.parameters]
    if found != expected:
        raise BadInput(
            f"parameters {', '.join(expected)} expected in the model, {', '.join(found)} found; fit it again"
        )
    return mechanism


def refuse_other_rig(model: Model, recording: Recording) -> None:
    """Raise BadInput where `recording` is of another machine than `model`."""
    rig = recording.rig
    expected = _flat(model.mechanism, model.effort_units, model.torque, model.geometry)
    found = _flat(rig.mechanism, rig.effort_units, rig.torque, rig.geometry if model.geometry else None)
    for what in expected:
        if expected[what] != found[what]:
            raise BadInput(
                f"a recording of the rig that was identified expected: {what} is {expected[what]} in the model, "
                f"{found[what]} in {recording.path.name}; fit a model to it"
            )


def _flat(mechanism: str, units: tuple[str, ...], torque: Torque, geometry: Geometry | None) -> dict[str, object]:
    sections = {"torque": torque, **({"geometry": geometry} if geometry else {})}
    fields = {f"{name}.{key}": value for name, section in sections.items() for key, value in section}
    return {"mechanism": mechanism, "the effort's unit": ", ".join(units), **fields}
