"""Presliding: dry friction that builds up over a small displacement (Dahl's model)."""

import numpy as np

from ident.basics.numba_cache import compiled
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from ident.dynamics.effects.c_code import CCode
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Column z / z_s - sgn v (n, dof, 1), with the bristle deflection z."""
    motion = inputs.motion
    deflection = compiled(_deflection)(np.ascontiguousarray(motion.position), shapes["z_s"])
    return (deflection - motion.direction)[:, :, None]


def _deflection(position: Floats, z_s: float) -> Floats:
    """Integrate dz = dq - |dq| z / z_s exactly along `position` (n, dof) to z / z_s (n, dof); NaN in gaps."""
    result = np.full(position.shape, np.nan)
    for joint in range(position.shape[1]):
        deflection, last = 0.0, np.nan
        for k in range(position.shape[0]):
            q = position[k, joint]
            if np.isnan(q):
                continue
            if not np.isnan(last):
                step = q - last
                decay = np.exp(-abs(step) / z_s)
                deflection = deflection * decay + np.sign(step) * (1 - decay)
            last = q
            result[k, joint] = deflection
    return result


effect = Additive(
    sentence="After a reversal, dry friction is not there at once: it builds up over a small displacement.",
    size="{a}, over {z_s}",
    symptom="The residual opposes Coulomb friction just behind each reversal, over the same angle each time.",
    causes="surfaces and seals that bend before they slide, gear teeth and bearings under preload",
    remedy="nothing is broken; a controller that holds position well wants the term in its feed-forward",
    record="many small reversals, some of them shorter than the displacement, with a fine encoder",
    equation="a (z / z_s - sgn v), z' = v - |v| z / z_s, a >= 0",
    axis="position",
    memory=True,
    parameters=(Quantity(name="a", unit="{effort}", meaning="dry friction that builds up", lower=0.0),),
    shapes=(
        Quantity(
            name="z_s",
            unit="{position}",
            meaning="displacement over which it builds up",
            lower=1e-5,
            upper=1.0,
            usual=0.05,  # three degrees: a spring with a rest angle that moves, not surfaces that bend
            initial_guesses=(1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3),
        ),
    ),
    columns=columns,
    c=CCode(
        state=("z", "last"),
        statements="""
            if (!first) {
                const real decay = exp(-fabs(q - *last) / z_s);
                *z = *z * decay + sign(q - *last) * (1.0 - decay);
            }
            *last = q;""",
        expression="a * (*z - direction)",
    ),
)
