"""Models with effects of any value, for exports."""

from collections.abc import Sequence

import numpy as np

import ident
from ident.dynamics import mechanisms
from ident.dynamics.effects.library import library
from ident.dynamics.structure import ModelStructure, Term
from ident.identification.model import Model, rig_of
from ident.identification.model_file import FittedParameter
from ident.identification.prediction import effect_terms
from recordings.recording import Floats
from recordings.rig import Axis, Rig
from tests.ident.conftest import TRUTH
from tests.ident.kept_models import MODELS

VALUES = {
    "N": 7.0, "which": 0.0, "e": 0.003, "t_c": 5.0, "t_e": 12.0, "t_r": 0.1, "T": 8.0, "low": -0.6, "high": 0.6,
    "alpha": 0.6, "z_s": 0.05, "v_s": 0.4, "c": 0.01, "motor": 0.4, "damping": 0.1, "compliance": 1e-4,
    "position_dependent_friction.low3": -0.3,
    "encoder_eccentricity.a": 0.01, "encoder_eccentricity.b": 0.004, "encoder_eccentricity.N": 3.0,
}  # fmt: skip
"""Values of parameters by name, or those of one effect or joint; others are random."""
JOINTS = {"power_law_friction": (1,), "position_dependent_friction": (0, 2)}
"""Joints of effects that stand in place of friction."""


def model_with(names: Sequence[str], axes: Sequence[Axis] = ()) -> Model:
    """A delta robot, or independent `axes`, with the effects `names`."""
    rig = rig_of(ident.load_model(MODELS / "lad.model.json").file)
    if not axes:
        return model_of(rig, np.abs(TRUTH), names)
    rig = Rig(name="bench", mechanism="axes", axes=tuple(axes))
    return model_of(rig, np.random.default_rng(0).uniform(0.5, 2.0, len(mechanisms.create(rig).parameters)), names)


def model_of(rig: Rig, base_values: Floats, names: Sequence[str]) -> Model:
    """The robot of `rig` with the parameters `base_values` (k,) and the effects `names`."""
    effects = library()
    base = ident.load_model(MODELS / "lad.model.json").file
    structure = ModelStructure(mechanisms.create(rig), rig)
    for name in names:
        joints = JOINTS.get(name, effects[name].possible_joints(rig))
        structure = structure.with_term(Term(name, effects[name], joints))
    rng = np.random.default_rng(1)
    values = [_value(entry.name, rng) for entry in structure.parameters[len(base_values) :]]
    x = np.concatenate([base_values, values])
    template = base.parameters[0]
    parameters: tuple[FittedParameter, ...] = tuple(
        template.model_copy(update={"name": entry.name, "value": float(value), "unit": entry.unit})
        for entry, value in zip(structure.parameters, x, strict=True)
        if entry.linear
    )
    file = base.model_copy(
        update={
            "mechanism": rig.mechanism, "geometry": rig.geometry if rig.mechanism == "delta" else None,
            "robot": rig.chain if rig.mechanism == "urdf" else None, "torque": rig.torque,
            "joints": rig.joint_names, "effort_units": rig.effort_units, "parameters": parameters, "assessment": None,
            "effects": tuple(names), "terms": effect_terms(structure, x),
        }
    )  # fmt: skip
    return Model(file, effects)


def _value(name: str, rng: np.random.Generator) -> float:
    whole, quantity = name.rstrip("123"), name.partition(".")[2].rstrip("123")
    keys = (key for key in (name, whole, quantity) if key in VALUES)
    random = rng.uniform(0.05, 0.3)
    return float(VALUES.get(next(keys, ""), random))
