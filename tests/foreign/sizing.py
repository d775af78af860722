"""Size of an effect: its torque that the base model with uniform rods cannot fit, as a share of the torque."""

import math

import numpy as np
from scipy.signal import butter, sosfiltfilt

from drivers.simulated.config import Links
from drivers.simulated.effect import HiddenEffect
from drivers.simulated.secant import nearest, unabsorbed
from recordings.recording import Floats
from tests.drivers.simulated.exact_delta import exact_torque
from tests.foreign.plant import Plant, Reported
from trajectories.kinematics import Unreachable

_BANDWIDTH = 30.0
"""Bandwidth of the analysis: -3 dB of the forward-backward filter [Hz]."""
_DECIMATION = 5
"""Decimation of the rows of the fit."""


class EffectSizer:
    """Measures the size of effects on one plant."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        rig, reference = plant.robot.rig, plant.reference
        self._cyclic_rows = np.flatnonzero(reference.repeat[:: reference.per_sample] >= 0)[::_DECIMATION]
        corner = _BANDWIDTH / (math.sqrt(2) - 1) ** 0.25
        self._low_pass = butter(2, min(corner, 0.45 * rig.rate), fs=rig.rate, output="sos")
        bare = plant.report()
        self._bare_position = bare.position
        self._basis = self._orthonormal_basis(bare)
        self._torque = self._filtered(self._torque_of(bare))
        self._bare_residual = self._residual(self._torque, self._basis)

    def size(self, effect: HiddenEffect) -> float:
        """Size of an effect on its joints; infinite if the robot cannot follow the motion."""
        try:
            change = unabsorbed(self._change(effect), [self._change(each) for each in effect.contained()])
        except Unreachable:
            return math.inf
        joints = [joint - 1 for joint in effect.joints]
        size = math.sqrt(np.mean(change[:, joints] ** 2) / np.mean(self._torque[:, joints] ** 2))
        return size if math.isfinite(size) else math.inf

    def _change(self, effect: HiddenEffect) -> Floats:
        """(m, 3) residual of the base model with the `effect` minus that without it [N m].

        Raises:
            Unreachable: the robot cannot follow the motion.
        """
        reported = self._plant.report((effect,))
        same = np.array_equal(reported.position, self._bare_position)
        basis = self._basis if same else self._orthonormal_basis(reported)
        return self._residual(self._filtered(self._torque_of(reported)), basis) - self._bare_residual

    def nearest(self, effect: HiddenEffect, wanted: float) -> tuple[HiddenEffect, float] | None:
        """Scale an effect to the possible size nearest to `wanted`; return it and its size; None: it has none."""
        return nearest(self.size, effect, wanted)

    def _torque_of(self, reported: Reported) -> Floats:
        """(m, 3) torque by the torque map of the rig."""
        return np.array(self._plant.robot.rig.torque.gain) * reported.voltage * np.abs(reported.voltage)

    def _filtered(self, signal: Floats) -> Floats:
        filtered: Floats = sosfiltfilt(self._low_pass, signal, axis=0)[self._cyclic_rows]
        return filtered

    def _orthonormal_basis(self, reported: Reported) -> Floats:
        """Orthonormal basis (3 rows, k) of the columns of the base model."""
        geometry, columns = self._plant.robot.rig.geometry, []
        motion = reported.position, reported.velocity, reported.acceleration
        massless = Links().model_copy(update=dict.fromkeys(Links.model_fields, 0.0))
        for mass in ("platform_mass", "rod_mass"):
            columns.append(exact_torque(geometry, massless.model_copy(update={mass: 1.0}), *motion))
        columns.append(np.cos(motion[0]))
        for joint in np.eye(3):
            columns += [joint * signal for signal in (motion[2], motion[1], np.sign(motion[1]))]
        matrix = np.stack([self._filtered(column) for column in columns], axis=2).reshape(-1, len(columns))
        return np.linalg.qr(matrix / np.linalg.norm(matrix, axis=0))[0]

    def _residual(self, torque: Floats, basis: Floats) -> Floats:
        flat = torque.ravel()
        residual: Floats = (flat - basis @ (basis.T @ flat)).reshape(torque.shape)
        return residual
