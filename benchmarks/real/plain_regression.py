"""Plain regression on an arm, by which its own model is measured. Written with Pinocchio, apart from `ident`."""

from collections.abc import Sequence

import numpy as np
import pinocchio

from ident.data.prepared_recording import PreparedRecording, _in_blocks
from ident.data.row_weights import moving_or_all, standstill_share
from ident.dynamics.motion import Motion
from recordings.recording import Floats

_STEPS = 30
"""Fits, each weighted by the residuals of the one before."""


class PlainRegression:
    """Base parameters of the links, viscous and Coulomb friction, offset and motor inertia, by least squares.

    Each joint is weighted by its own residual.
    """

    def __init__(self, urdf: str, joints: Sequence[str], train: Sequence[PreparedRecording]) -> None:
        # Of a joint without limits, Pinocchio would want cosine and sine.
        limits = '"revolute"><limit lower="-100" upper="100" effort="1" velocity="1"/>'
        self.model, dof = pinocchio.buildModelFromXML(urdf.replace('"continuous">', limits)), len(joints)
        position, velocity, acceleration = np.random.default_rng(5).uniform(-2, 2, (3, 200, dof))
        motion = Motion(position, velocity, acceleration, np.sign(velocity))
        columns = self._physical(motion).reshape(200 * dof, -1)
        self.independent = self._independent(columns)
        rows = [moving_or_all(each, standstill_share(each)) for each in train]
        regressors, deviation = list(map(self.regressor, train)), np.ones(dof)
        for _ in range(_STEPS):
            weighted = np.concatenate([(A / deviation[:, None])[r] for A, r in zip(regressors, rows, strict=True)])
            torque = np.concatenate([(each.torque / deviation)[r] for each, r in zip(train, rows, strict=True)])
            size = np.linalg.norm(weighted, axis=0)
            self.parameters = np.linalg.lstsq(weighted / size, torque, rcond=None)[0] / size
            residuals = [np.where(r, self.residual(each), np.nan) for each, r in zip(train, rows, strict=True)]
            deviation = rms(np.concatenate(residuals))

    def residual(self, prepared: PreparedRecording) -> Floats:
        """(m, dof) measured minus computed torque."""
        residual: Floats = prepared.torque - self.regressor(prepared) @ self.parameters
        return residual

    def regressor(self, prepared: PreparedRecording) -> Floats:
        """(m, dof, k) columns, filtered as the torque."""
        return _in_blocks(prepared.preprocessed, lambda motion: self._physical(motion)[:, :, self.independent])

    def _physical(self, motion: Motion) -> Floats:
        data = self.model.createData()
        signals = (motion.position, motion.velocity, motion.acceleration)
        links = [
            pinocchio.computeJointTorqueRegressor(self.model, data, *at).copy()
            for at in zip(*map(np.nan_to_num, signals), strict=True)
        ]
        joints = (motion.acceleration, motion.velocity, motion.direction, np.ones_like(motion.velocity))
        each = np.eye(motion.position.shape[1])
        return np.concatenate([np.array(links), *(signal[:, :, None] * each for signal in joints)], axis=2)

    @staticmethod
    def _independent(columns: Floats) -> list[int]:
        """The rank of the leading columns grows with each of these."""
        kept: list[int] = []
        for column in range(columns.shape[1]):
            candidate = columns[:, [*kept, column]]
            size = np.linalg.norm(candidate, axis=0)
            if size[-1] > 1e-9 and np.linalg.svd(candidate / size, compute_uv=False)[-1] > 1e-7:
                kept.append(column)
        return kept


def rms(residual: Floats) -> Floats:
    """(dof,) of the rows that are known."""
    result: Floats = np.sqrt(np.nanmean(residual**2, axis=0))
    return result
