"""Exponent of the torque map that differs from the rig file's."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.torque_map import torque_from_voltage
from recordings.recording import Floats

_MIN_EXPONENT = 0.1
"""Smallest exponent."""


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Invert torque = gain |v|^p sgn v for the voltage v, and apply the rig's torque map to it (n, dof)."""
    nominal = 2.0 if inputs.rig.torque.map == "square" else 1.0
    exponent = np.maximum(nominal + values["excess"], _MIN_EXPONENT)
    voltage = np.sign(torque) * np.abs(torque / np.array(inputs.rig.torque.gain)) ** (1 / exponent)
    return torque_from_voltage(voltage, inputs.rig.torque)


effect = Signal(
    sentence="Torque does not grow with the power of the voltage that the rig file says.",
    size="{excess}",
    symptom="The residual bends away over the load, to opposite sides for the two signs of the torque.",
    causes="a motor near magnetic saturation, a voltage that stands for current in another way than assumed",
    remedy="calibrate torque against voltage at several loads, and correct the map in the rig file",
    record="the same motion with several known payloads, up to the largest torque",
    equation="torque = gain |v|^(p + excess) sgn v, p = 2 (square) or 1 (linear)",
    axis="load",
    parameters=(
        Quantity(
            name="excess",
            unit="1",
            meaning="exponent beyond the rig's",
            lower=-0.9,
            upper=2.0,
            initial_guesses=(0.02,),
        ),
    ),
    report=report,
    unobservable=lambda rig, torque_measured: "The torque itself was recorded." if torque_measured else None,
)
