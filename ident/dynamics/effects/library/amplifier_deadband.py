"""Dead band of the amplifier."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.torque_map import amplifier_unobservable, torque_from_voltage, voltage_from_torque
from recordings.recording import Floats

_SMOOTH = 0.02
"""Width of the smoothed sign around zero [V]; a step would have no derivative."""


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Add the dead band to the voltage that gives the torque (n, dof)."""
    voltage = voltage_from_torque(torque, inputs.rig.torque)
    return torque_from_voltage(voltage + values["width"] * np.tanh(voltage / _SMOOTH), inputs.rig.torque)


effect = Signal(
    sentence="The amplifier does not answer to small commands: within a band around zero the motor gets no voltage.",
    size="± {width}",
    symptom="The residual steps where the torque changes its sign, and grows with the load.",
    causes="dead time between the transistors of the output stage, a deliberate dead zone in its settings",
    remedy="compensate the dead time in the amplifier, or report the voltage at the motor",
    record="slow motion through places where the torque changes its sign, with the command recorded",
    equation="command = v + width sgn v",
    axis="load",
    parameters=(
        Quantity(
            name="width", unit="V", meaning="half of the dead band", lower=0.0, upper=5.0, initial_guesses=(0.01,)
        ),
    ),
    report=report,
    unobservable=amplifier_unobservable,
)
