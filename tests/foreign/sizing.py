"""How large an effect is: what a fit of the base model with uniform rods leaves of it, as a share of the torque."""

import math

import numpy as np
from scipy.signal import butter, sosfiltfilt

from drivers.simulated.config import Links
from drivers.simulated.effect import HiddenEffect
from drivers.simulated.secant import solve
from recordings.recording import Floats
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign.plant import Plant, Reported
from trajectories.kinematics import Unreachable

_BANDWIDTH = 30.0
"""Of the analysis, -3 dB forwards and backwards together [Hz]."""
_EVERY = 5
"""Samples between two rows of the fit."""
_TOLERANCE = 0.01


class EffectSizer:
    """Measures effects on one plant."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        rig, course = plant.robot.rig, plant.course
        self._repeating = np.flatnonzero(course.repeat[:: course.per_sample] >= 0)[::_EVERY]
        corner = _BANDWIDTH / (math.sqrt(2) - 1) ** 0.25
        self._low_pass = butter(2, min(corner, 0.45 * rig.rate), fs=rig.rate, output="sos")
        bare = plant.report()
        self._bare_position = bare.position
        self._basis = self._orthogonal(bare)
        self._torque = self._filtered(self._torque_of(bare))
        self._left = self._remaining(self._torque, self._basis)

    def size(self, effect: HiddenEffect) -> float:
        """The effect's size on its joints; infinite where the robot cannot follow."""
        try:
            reported = self._plant.report((effect,))
            same = np.array_equal(reported.position, self._bare_position)
            basis = self._basis if same else self._orthogonal(reported)
        except Unreachable:
            return math.inf
        residual = self._remaining(self._filtered(self._torque_of(reported)), basis)
        joints = [joint - 1 for joint in effect.joints]
        size = math.sqrt(np.mean((residual - self._left)[:, joints] ** 2) / np.mean(self._torque[:, joints] ** 2))
        return size if math.isfinite(size) else math.inf

    def nearest(self, effect: HiddenEffect, wanted: float) -> tuple[HiddenEffect, float] | None:
        """The effect with the strength that brings its size nearest to `wanted`, and that size; None: it has none."""
        parameters = type(effect)().model_dump()
        sign = math.copysign(1.0, effect.model_dump()[effect.strength()])
        scaled = solve(
            lambda strength: self.size(effect.scaled(sign * strength)),
            wanted,
            start=abs(parameters[effect.strength()]),
            largest=effect.largest(),
            tolerance=_TOLERANCE,
        )
        return None if scaled is None else (effect.scaled(sign * scaled[0]), scaled[1])

    def _torque_of(self, reported: Reported) -> Floats:
        """(m, 3) by the rig's map."""
        return np.array(self._plant.robot.rig.torque.gain) * reported.voltage * np.abs(reported.voltage)

    def _filtered(self, signal: Floats) -> Floats:
        filtered: Floats = sosfiltfilt(self._low_pass, signal, axis=0)[self._repeating]
        return filtered

    def _orthogonal(self, reported: Reported) -> Floats:
        """Orthonormal basis (3 rows, k) of the model's columns."""
        geometry, columns = self._plant.robot.rig.geometry, []
        motion = reported.position, reported.velocity, reported.acceleration
        nothing = Links().model_copy(update=dict.fromkeys(Links.model_fields, 0.0))
        for part in ("platform_mass", "rod_mass"):
            columns.append(exact_torque(geometry, nothing.model_copy(update={part: 1.0}), *motion))
        columns.append(np.cos(motion[0]))
        for joint in np.eye(3):
            columns += [joint * signal for signal in (motion[2], motion[1], np.sign(motion[1]))]
        matrix = np.stack([self._filtered(column) for column in columns], axis=2).reshape(-1, len(columns))
        return np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0))[0]

    def _remaining(self, torque: Floats, basis: Floats) -> Floats:
        flat = torque.ravel()
        residual: Floats = (flat - basis @ (basis.T @ flat)).reshape(torque.shape)
        return residual
