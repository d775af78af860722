"""Payload whose mass a rig file calls unknown: a parameter of a fit with recordings of other payloads.

No effect of the library: it is in a model where a recording declares it, and nowhere else.
"""

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats

NAME = "unknown_payload"


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """(n, dof, 1) torque of 1 kg where this recording carries the payload; else 0."""
    unit = [(1.0, place) for mass, place in inputs.beyond if np.isnan(mass)]
    torque = mechanisms.torque_of_masses(mechanisms.create(inputs.rig), unit, inputs.motion)
    return np.where(np.isfinite(inputs.motion.velocity), torque, np.nan)[:, :, None]


effect = Additive(
    sentence="The payload of a recording is unknown.",
    symptom="Weight and inertia of a mass at platform or tool, in the recordings that declare it.",
    causes="an object that was not weighed",
    remedy="write the mass that was found into the rig file",
    equation="torque of a mass m at payload.com, m >= 0",
    axis="acceleration",
    whole_robot=True,
    on_arm=True,
    parameters=(Quantity(name="m", unit="kg", meaning="mass of the payload", lower=0.0),),
    columns=columns,
)
