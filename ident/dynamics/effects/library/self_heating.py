"""Friction that falls as its own power warms the joint, where no thermometer says so."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import quantities
from ident.dynamics.effects.base import Additive, Quantity, Shapes
from recordings.recording import Floats


def columns(inputs: EffectInputs, shapes: Shapes) -> Floats:
    """Friction of the cold joint times its warmth (n, dof, 1); cold at first, at the mean power in gaps."""
    from scipy.signal import lfilter

    motion = inputs.motion
    c_v, c_c = (np.maximum(quantities.quantity(name, inputs), 0.0) for name in ("c_v", "c_c"))
    power = c_v * motion.velocity**2 + c_c * motion.direction * motion.velocity
    known = np.isfinite(power)
    total = np.where(known, power, 0.0).sum(axis=0)
    relative = np.where(known, power, np.nan) * known.sum(axis=0) / np.where(total > 0, total, 1.0)
    decay = np.exp(-1 / (inputs.rate * shapes["T"]))
    warmth = lfilter([0.0, 1 - decay], [1.0, -decay], np.where(known, relative, 1.0), axis=0)
    return ((c_v * motion.velocity + c_c * motion.direction) * warmth)[:, :, None]


effect = Additive(
    sentence="Its own friction warms the joint, which then rubs less.",
    size="{k:%}, in {T}",
    symptom="The residual opposes the motion, and shrinks the sooner the harder the joint rubs; rest brings it back.",
    causes="grease and oil that get thinner with warmth, in a small gear that moves much",
    remedy="warm the machine up before recording; measure the temperature, for the feed-forward as well",
    record="from cold: one motion until nothing changes any more, rest, and the same again",
    equation="(c_v v + c_c sgn v) k H, T H' = P / mean P - H, P = c_v v^2 + c_c |v|, k <= 0",
    axis="time",
    needs=("no temperature",),
    memory=True,
    parameters=(
        Quantity(
            name="k",
            unit="1",
            meaning="relative change of friction at its mean power, after a long time",
            lower=-1.0,  # beyond, the warm joint would not rub at all
            upper=0.0,
        ),
    ),
    shapes=(
        Quantity(
            name="T",
            unit="s",
            meaning="time constant of warming",
            lower=0.5,
            upper=1e4,
            max_durations=3.0,  # slower warming is a straight line over time
            least=2.0,  # no gear, brake or grease warms up sooner
            initial_guesses=(2.0, 6.0, 20.0, 60.0),
        ),
    ),
    columns=columns,
)
