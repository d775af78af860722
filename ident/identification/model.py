"""An identified model as an object: torque, voltage and inertia for any motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Effect
from ident.dynamics.inverse_dynamics import InverseDynamics
from ident.dynamics.motion import Motion
from ident.dynamics.torque_map import voltage_from_torque
from ident.identification import model_file
from ident.identification.identify import Identification
from ident.identification.model_file import ModelFile
from ident.identification.prediction import structure_of
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Axis, Rig


@dataclass(frozen=True, eq=False)
class Model:
    """An identified model: a mechanism with effects, and the values of their parameters.

    Positions are those that the encoders report. Arrays are time-first, (n, dof), in SI units: [rad], [rad/s],
    [rad/s^2] and [N m] for a revolute joint, [m], [m/s], [m/s^2] and [N] for a prismatic one.
    """

    file: ModelFile
    """Content of the model file, with the parameters, their intervals, and what they were fitted to."""
    library: Mapping[str, Effect]
    """Effects by name, among them those of the model."""
    identification: Identification | None = None
    """The fit with its data; None for a model that was loaded."""

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the effects that were added to the mechanism, in this order."""
        return self.file.effects

    @property
    def parameters(self) -> dict[str, float]:
        """Identified parameters by name, in SI units."""
        return {parameter.name: parameter.value for parameter in self.file.parameters}

    def save(self, path: str | Path) -> None:
        """Write the model file `path`, replacing an existing file.

        Raises:
            BadInput: the file cannot be written, or is named like a recording.
        """
        if Path(path).suffix == ".mcap":
            raise BadInput(f"{path}: a model's name expected, a recording's (.mcap) found; give it another ending")
        try:
            model_file.save(self.file, Path(path))
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or error
            raise BadInput(f"model file {path} cannot be written: {reason}; choose another place") from None

    def torque(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> Floats:
        """Torque (n, dof) that a motion takes: Eq. (26), with all effects of the model.

        q, qd, qdd: (n, dof) position, velocity, acceleration.
        dt: time from row to row [s], for effects that remember what was before.
        t: (n,) time since the run began [s], for effects that change with it.
        temperature: (n, dof) temperature of the drives [degC], for effects that depend on it.

        Raises:
            BadInput: an array has another shape, or an effect needs what is not given.
        """
        return self._dynamics.torque(self._inputs(q, qd, qdd, dt, t, temperature))

    def voltage(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None = None,
        t: ArrayLike | None = None,
        temperature: ArrayLike | None = None,
    ) -> Floats:
        """Operating voltage (n, dof) [V] that a motion takes, by the torque map and the effects between the two.

        Arguments and errors: as `torque`.
        """
        reported = self._dynamics.reported(self._inputs(q, qd, qdd, dt, t, temperature))
        return voltage_from_torque(reported, self.file.torque)

    def inertia(self, q: ArrayLike) -> Floats:
        """Inertia matrix D(q) (n, dof, dof) at positions `q` (n, dof), Eq. (27) [kg m^2, or kg].

        Raises:
            BadInput: `q` has another shape.
        """
        position = _array(q, "q")
        at_rest = self._motion(position, np.zeros_like(position), np.zeros_like(position))
        inputs = self._dynamics.inputs(at_rest)
        still = inputs.motion

        def accelerated(joint: int) -> Motion:
            unit = np.zeros_like(still.acceleration)
            unit[:, joint] = 1.0
            return Motion(still.position, still.velocity, unit, still.direction)

        joints = range(still.position.shape[1])
        columns = [inputs.rigid_at(accelerated(joint)) - inputs.rigid for joint in joints]
        return np.stack(columns, axis=2)

    @cached_property
    def _dynamics(self) -> InverseDynamics:
        return InverseDynamics(*structure_of(self.file, _rig(self.file), self.library))

    def _inputs(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        dt: float | None,
        t: ArrayLike | None,
        temperature: ArrayLike | None,
    ) -> EffectInputs:
        motion = self._motion(q, qd, qdd)
        if dt is not None and not 0 < float(_array(dt, "dt")) < np.inf:
            raise BadInput(f"dt, a time step above 0 s, expected, {dt!r} found")
        time, shape = _optional(t, "t", motion.position.shape[:1]), motion.position.shape
        return self._dynamics.inputs(motion, dt, time, _optional(temperature, "temperature", shape))

    def _motion(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> Motion:
        arrays = [_array(x, name) for x, name in ((q, "q"), (qd, "qd"), (qdd, "qdd"))]
        dof = len(self.file.joints)
        if any(x.ndim != 2 or x.shape != arrays[0].shape or x.shape[1] != dof for x in arrays):
            shapes = ", ".join(str(x.shape) for x in arrays)
            raise BadInput(f"q, qd and qdd of shape (n, {dof}) expected, {shapes} found; give one row per instant")
        position, velocity, acceleration = arrays
        return Motion(position, velocity, acceleration, np.sign(velocity))


def _array(x: ArrayLike, name: str) -> Floats:
    """Return a copy, so that nobody writes into the user's array."""
    try:
        return np.array(x, float)
    except (TypeError, ValueError):
        raise BadInput(f"{name}: an array of real numbers expected, {type(x).__name__} found") from None


def _optional(x: ArrayLike | None, name: str, shape: tuple[int, ...]) -> Floats | None:
    if x is None:
        return None
    array = _array(x, name)
    if array.shape != shape:
        raise BadInput(f"{name} of shape {shape} expected, {array.shape} found; give one value per instant")
    return array


def _rig(file: ModelFile) -> Rig:
    """What of the rig a model file holds: mechanism, geometry and torque map."""
    if file.mechanism == "delta":
        assert file.geometry is not None
        return Rig(name="model", geometry=file.geometry, torque=file.torque)
    weights = {parameter.name for parameter in file.parameters if parameter.name.startswith("G_")}
    axes = tuple(
        Axis(
            type="revolute" if unit == "N m" else "prismatic",
            gravity=bool(weights & {f"G_{number}", f"G_c{number}"}),
        )
        for number, unit in enumerate(file.effort_units, start=1)
    )
    return Rig(name="model", mechanism="axes", axes=axes, torque=file.torque)
