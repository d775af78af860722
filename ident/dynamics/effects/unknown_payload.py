"""Payload that a rig file calls unknown: parameters of a fit with recordings of other payloads.

No effect of the library: it is in a model where a recording declares it, and nowhere else.
"""

from collections.abc import Sequence

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats, Recording
from recordings.urdf import Vector

NAME = "unknown_payload"
_FARTHEST = 5.0
"""Distance of the centre of mass from the tool's origin along each axis, at most [m]."""


def _columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """(n, dof, 1) torque of 1 kg where this recording carries the payload; else 0."""
    found: Vector | None = (shapes["x"], shapes["y"], shapes["z"]) if shapes else None
    unit = [(1.0, found or place) for mass, place in inputs.beyond if np.isnan(mass)]
    torque = mechanisms.torque_of_masses(mechanisms.create(inputs.rig), unit, inputs.motion)
    return np.where(np.isfinite(inputs.motion.velocity), torque, np.nan)[:, :, None]


of_known_place = Additive(
    sentence="The payload of a recording is unknown.",
    symptom="Weight and inertia of a mass at platform or tool, in the recordings that declare it.",
    causes="an object that was not weighed",
    remedy="write the mass that was found into the rig file",
    equation="torque of a mass m at payload.com, m >= 0",
    axis="acceleration",
    whole_robot=True,
    on_arm=True,
    parameters=(Quantity(name="m", unit="kg", meaning="mass of the payload", lower=0.0),),
    columns=_columns,
)

of_unknown_place = of_known_place.changed(
    equation="torque of a mass m at (x, y, z) of the tool, m >= 0",
    shapes=tuple(
        Quantity(
            name=name,
            unit="m",
            meaning=f"its centre of mass along {name}",
            lower=-_FARTHEST,
            upper=_FARTHEST,
            initial_guesses=(0.1,),
        )
        for name in "xyz"
    ),
)


def needed_by(recordings: Sequence[Recording]) -> Additive | None:
    """The unknown payload of `recordings`; None where all are known. Its place on a delta's platform is no matter."""
    places = [place for each in recordings for mass, place in each.beyond if np.isnan(mass)]
    if not places:
        return None
    searched = np.isnan(places).any() and recordings[0].rig.mechanism != "delta"
    return of_unknown_place if searched else of_known_place
