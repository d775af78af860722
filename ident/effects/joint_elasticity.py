"""A gear that gives way, between the motor with the encoder and the arm."""

import numpy as np

from ident import signals
from ident.effects import Quantity, Signal, Values
from ident.motion import Motion
from ident.view import View
from recordings.recording import Floats

_HIGHEST = 40.0
"""The twist is taken from the torque up to here [Hz]; derivatives of more would be noise."""
_ROUNDS = 2
"""The twist depends on the torque, which depends on the twist."""


def report(torque: Floats, view: View, values: Values) -> Floats:
    """What the motors give instead of `torque` (n, dof) if the arms lag behind them by torque / stiffness."""
    rigid = view.arm_torque(view.motion)
    load = rigid
    for _ in range(_ROUNDS):
        load = view.arm_torque(_lagging(view, load * values["compliance"]))
    return torque + np.where(np.isfinite(load), load - rigid, 0.0)


def _lagging(view: View, twist: Floats) -> Motion:
    """The motion, less the `twist` (n, dof) up to _HIGHEST; the motion itself where that is not known."""
    motion, rate = view.motion, view.rate
    smooth = signals.convolve(twist, signals.low_pass(min(_HIGHEST, rate / 6), rate))
    parts = smooth, signals.first_derivative(smooth, rate), signals.second_derivative(smooth, rate)
    known = np.isfinite(parts[2]).all(axis=1)[:, None]
    angle, speed, acceleration = (np.where(known, part, 0.0) for part in parts)
    return Motion(
        motion.position - angle, motion.velocity - speed, motion.acceleration - acceleration, motion.direction
    )


effect = Signal(
    sentence="Between motor and arm something gives way: under load the arm lags behind the encoder.",
    looks="The residual follows fast changes of the torque, like a mass that swings on a spring.",
    causes="a gear with a soft flexspline, a belt, a long shaft or coupling, a clamping that has come loose",
    remedy="check couplings and clamps; use smoother motion, or a controller that knows the spring",
    equation="arm angle = motor angle - compliance * torque of the arm; the motor's inertia is on the encoder's side",
    axis="acceleration",
    parameters=(
        Quantity(
            name="compliance",
            unit="{position}/({effort})",
            meaning="1 / stiffness",
            lower=0.0,
            upper=0.02,
            starts=(1e-4,),
        ),
    ),
    report=report,
)
