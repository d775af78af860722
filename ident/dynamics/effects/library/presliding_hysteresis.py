"""Dry friction that builds up as the joint starts to move."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.numba_cache import compiled
from recordings.recording import Floats


def columns(view: EffectInputs, shapes: Shapes) -> Floats:
    """z / z_s - sgn v (n, dof, 1), of bristles that bend by z."""
    motion = view.motion
    bent = compiled(_bent)(np.ascontiguousarray(motion.position), shapes["z_s"])
    difference: Floats = (bent - motion.direction)[:, :, None]
    return difference


def _bent(position: Floats, z_s: float) -> Floats:
    """z / z_s (n, dof) along `position` (n, dof): dz = dq - |dq| z / z_s, exact for each step; NaN in gaps."""
    result = np.full(position.shape, np.nan)
    for joint in range(position.shape[1]):
        bent, last = 0.0, np.nan
        for k in range(position.shape[0]):
            q = position[k, joint]
            if np.isnan(q):
                continue
            if not np.isnan(last):
                step = q - last
                kept = np.exp(-abs(step) / z_s)
                bent = bent * kept + np.sign(step) * (1 - kept)
            last = q
            result[k, joint] = bent
    return result


effect = Additive(
    sentence="After a reversal, dry friction is not there at once: it builds up over a small displacement.",
    symptom="The residual opposes Coulomb friction just behind each reversal, over the same angle each time.",
    causes="surfaces and seals that bend before they slide, gear teeth and bearings under preload",
    remedy="nothing is broken; a controller that holds position well wants the term in its feed-forward",
    equation="a (z / z_s - sgn v), z' = v - |v| z / z_s, a >= 0",
    axis="position",
    coefficients=(Quantity(name="a", unit="{effort}", meaning="dry friction that builds up", lower=0.0),),
    shapes=(
        Quantity(
            name="z_s",
            unit="{position}",
            meaning="displacement over which it builds up",
            lower=1e-5,
            upper=1.0,
            initial_guesses=(1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3),
        ),
    ),
    columns=columns,
)
