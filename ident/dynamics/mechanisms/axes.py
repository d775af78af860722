"""Independent axes: joints without coupling, such as one drive on a bench or a dismounted arm.

    effort_i = I_i a_i + c_vi v_i + c_ci sgn(v_i) [+ weight]

Friction is positive where it opposes motion. The weight of a revolute joint is G_ci cos(q_i) + G_si sin(q_i),
for any zero of the angle; that of a prismatic joint is constant.
"""

from dataclasses import dataclass

import numpy as np

from ident.dynamics.mechanisms import Parameter, friction_parameters
from ident.dynamics.motion import Motion
from ident.dynamics.platform import GRAVITY
from recordings.recording import Floats
from recordings.rig import Axis, Rig
from recordings.urdf import Vector


def create(rig: Rig) -> "Axes":
    """Create the axes described by `rig`."""
    return Axes(rig.axes)


@dataclass(frozen=True)
class Axes:
    """n independent joints."""

    axes: tuple[Axis, ...]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Inertias, viscous and Coulomb friction of all joints, then the weights of joints under gravity."""
        numbered = list(enumerate(self.axes, start=1))
        return (
            *(_inertia(i, axis) for i, axis in numbered),
            *friction_parameters([axis.type for axis in self.axes]),
            *(weight for i, axis in numbered if axis.gravity for weight in _weights(i, axis)),
        )

    def regressor(self, motion: Motion) -> Floats:
        """Compute the columns (n, dof, k), in the order of `parameters`."""
        dof = len(self.axes)
        columns = np.zeros((*motion.position.shape, len(self.parameters)))
        joints = np.arange(dof)
        for first, signal in enumerate((motion.acceleration, motion.velocity, motion.direction)):
            columns[:, joints, first * dof + joints] = signal
        column = 3 * dof
        for joint, axis in enumerate(self.axes):
            if axis.gravity:
                for column_values in _weight_columns(axis, motion.position[:, joint]):
                    columns[:, joint, column] = column_values
                    column += 1
        return columns

    def inertia(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the inertia matrix (n, dof, dof) [kg m^2 or kg]: diagonal, and the same everywhere."""
        matrix = np.diag(parameters[: len(self.axes)])
        return np.where(np.isfinite(motion.position)[:, :, None], matrix, np.nan)

    def gravity(self, motion: Motion, parameters: Floats) -> Floats:
        """Compute the weight (n, dof) [N m or N] of the joints under gravity."""
        first = 3 * len(self.axes)
        return self.regressor(motion)[:, :, first:] @ parameters[first:]

    def torque_per_mass(self, motion: Motion, place: Vector) -> Floats:
        """Compute the torque (n, dof) [N m/kg or N/kg] of 1 kg on the last joint.

        A revolute joint turns it about y, from x towards z, and gravity is along -z; a prismatic one lifts it.
        """
        torque, (x, _, z), axis = np.zeros_like(motion.position), place, self.axes[-1]
        weight = GRAVITY if axis.gravity else 0.0
        q, acceleration = motion.position[:, -1], motion.acceleration[:, -1]
        if axis.type == "prismatic":
            torque[:, -1] = acceleration + weight
        else:
            torque[:, -1] = (x**2 + z**2) * acceleration + weight * (x * np.cos(q) - z * np.sin(q))
        return torque

    def nominal_torque(self, motion: Motion) -> None:
        """Return None: there is no published model of such axes."""


def _inertia(i: int, axis: Axis) -> Parameter:
    if axis.type == "revolute":
        return Parameter(f"I_{i}", "kg m^2", f"inertia of joint {i} and its motor", nonnegative=True)
    return Parameter(f"m_{i}", "kg", f"mass moved by joint {i}, with its motor's inertia", nonnegative=True)


def _weights(i: int, axis: Axis) -> tuple[Parameter, ...]:
    if axis.type == "prismatic":
        return (Parameter(f"G_{i}", "N", f"force that holds joint {i} against its weight"),)
    return tuple(
        Parameter(
            f"G_{suffix}{i}", "N m", f"part of the torque that holds joint {i} which goes with {shape} of its angle"
        )
        for suffix, shape in (("c", "the cosine"), ("s", "the sine"))
    )


def _weight_columns(axis: Axis, position: Floats) -> tuple[Floats, ...]:
    """Columns (n,) of the parameters of `_weights`."""
    if axis.type == "prismatic":
        return (np.where(np.isfinite(position), 1.0, np.nan),)
    return np.cos(position), np.sin(position)
