"""The quantities of formulas, and the columns that formulas give."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.formula import OF_JOINT, Formula, arguments
from ident.dynamics.mechanisms import known_masses
from recordings.errors import BadInput
from recordings.recording import Floats

REFERENCE_TEMPERATURE = 25.0
"""Of a drive whose temperature was not measured [degC]."""


def _per_joint(name: str) -> Callable[[EffectInputs], Floats]:
    return lambda inputs: np.array(
        [inputs.parameters[f"{name}{joint + 1}"] for joint in range(inputs.motion.velocity.shape[1])]
    )


def _temperature(inputs: EffectInputs) -> Floats:
    measured = np.isfinite(inputs.temperature).any(axis=0)
    return np.where(measured, inputs.temperature, REFERENCE_TEMPERATURE)


QUANTITIES: dict[str, Callable[[EffectInputs], Any]] = {
    "q": lambda inputs: inputs.motion.position,
    "qd": lambda inputs: inputs.motion.velocity,
    "qdd": lambda inputs: inputs.motion.acceleration,
    "direction": lambda inputs: inputs.motion.direction,
    "t": lambda inputs: inputs.time[:, None],
    "dt": lambda inputs: 1 / inputs.rate,
    "temperature": _temperature,
    "rigid": lambda inputs: inputs.rigid,
    "load": lambda inputs: inputs.load,
    "c_v": _per_joint("c_v"),
    "c_c": _per_joint("c_c"),
    "m_p": lambda inputs: inputs.parameters["m_p"] + sum(mass for mass, _ in known_masses(inputs.beyond)),
    "T_g": lambda inputs: inputs.parameters["T_g"],
    "m_d": lambda inputs: inputs.parameters["m_d"],
    "L1": lambda inputs: inputs.rig.geometry.L1,
    "cos_phi": lambda inputs: np.cos(inputs.rig.geometry.phi),
    "sin_phi": lambda inputs: np.sin(inputs.rig.geometry.phi),
    "J": lambda inputs: inputs.platform.jacobian.swapaxes(0, 1),
    "platform_velocity": lambda inputs: inputs.platform.velocity.T[:, :, None],
    "torque_per_mass": lambda inputs: inputs.torque_per_mass,
    "balls_dry": lambda inputs: inputs.balls[0],
    "balls_viscous": lambda inputs: inputs.balls[1],
    "rods": lambda inputs: inputs.platform.torque_of_rods,
}
"""What a quantity is: a number, (dof,), (n, 1) or (n, dof); three of them for a vector. Their meanings: `formula`."""


def quantity(name: str, inputs: EffectInputs) -> Any:
    """The quantity `name`; with a number behind it, that of this joint (from 1), (n, 1).

    Raises:
        BadInput: there is no such joint.
    """
    if found := OF_JOINT.fullmatch(name):
        values, joint = QUANTITIES[found[1]](inputs), int(found[2])
        if joint > values.shape[1]:
            raise BadInput(
                f"effect: quantities of {values.shape[1]} joints expected, {name} found; change the formula"
            )
        return values[:, joint - 1, None]
    return QUANTITIES[name](inputs)


def columns(formula: Formula, inputs: EffectInputs, shapes: Any) -> Floats:
    """Compute the columns (n, dof, c) of a `formula`, with `shapes` by name; NaN where the velocity is NaN."""
    velocity = inputs.motion.velocity
    values = (shapes[name] if name in shapes else quantity(name, inputs) for name in arguments(formula))
    result = formula(*values)
    each = result if isinstance(result, tuple) else (result,)
    known = np.where(np.isfinite(velocity), 0.0, np.nan)
    return np.stack([known + column for column in each], axis=2)
