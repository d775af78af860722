"""Voltage saturation of the amplifier."""

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Quantity, Signal, Values
from ident.dynamics.torque_map import amplifier_unobservable, torque_from_voltage, voltage_from_torque
from recordings.recording import Floats

_NEAR = 0.995
"""Share of the highest voltage above which the command is not invertible."""


def report(torque: Floats, inputs: EffectInputs, values: Values) -> Floats:
    """Invert v = u / (1 + |u inverse_level|^n)^(1/n) for the command u, where v gives the torque (n, dof)."""
    voltage = voltage_from_torque(torque, inputs.rig.torque)
    knee = values["n"]
    used = np.minimum(np.abs(voltage * values["inverse_level"]), _NEAR)
    return torque_from_voltage(voltage / (1 - used**knee) ** (1 / knee), inputs.rig.torque)


def suggest(inputs: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """Suggest levels around the largest voltage of the model, each with several knees."""
    largest = float(np.nanmax(np.abs(voltage_from_torque(inputs.rigid, inputs.rig.torque))))
    if not largest:
        return []
    return [
        {"inverse_level": use / largest, "n": knee} for use in (0.6, 0.8, 0.95, 1.1, 1.3) for knee in (3.0, 6.0, 12.0)
    ]


effect = Signal(
    sentence="The amplifier runs out of voltage: large commands give less than they ask for.",
    size="above 1 / ({inverse_level})",
    symptom="The residual grows steeply where the torque is largest.",
    causes="a supply that is too low or sags, a current limit, the back-EMF at high speed",
    remedy="slow the motion down, raise the supply, or report the voltage at the motor",
    record="the hardest motion that is allowed, with the heaviest load, and a gentle one to compare",
    equation="command u: v = u / (1 + |u inverse_level|^n)^(1/n)",
    axis="load",
    multistart=4,
    parameters=(
        Quantity(
            name="inverse_level",
            unit="1/V",
            meaning="1 / highest voltage",
            lower=0.0,
            upper=3.0,
            min_use=0.5,
            initial_guesses=(0.05,),
        ),
    ),
    shapes=(
        Quantity(name="n", unit="1", meaning="sharpness of the knee", lower=1.5, upper=40.0, initial_guesses=(6.0,)),
    ),
    report=report,
    suggest=suggest,
    unobservable=amplifier_unobservable,
)
