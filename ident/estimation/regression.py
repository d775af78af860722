"""A model on a recording as a linear regression: torque = offset + regressor . linear parameters.

The nonlinear parameters are fixed. Around the least-squares solution this is exact without signal effects, else
accurate to first order.
"""

from dataclasses import dataclass

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.structure import ModelStructure
from ident.estimation import chunks
from recordings.recording import Floats


@dataclass(frozen=True, eq=False)
class Regression:
    """Rows of one recording for the k linear parameters of a model."""

    prepared: PreparedRecording
    regressor: Floats
    """(m, dof, k)."""
    torque: Floats
    """(m, dof) measured torque [N m]; NaN where a row is not usable."""
    offset: Floats | None = None
    """(m, dof) predicted torque that does not depend on the parameters [N m]; None: zero."""

    @classmethod
    def of_mechanism(cls, prepared: PreparedRecording) -> "Regression":
        """Return the regression for the mechanism without effects."""
        return cls(prepared, prepared.regressor, prepared.torque)

    def rows(self) -> tuple[Floats, Floats]:
        """Regressor (r, k) and torque (r,) of the usable rows, one joint after the other."""
        usable = np.isfinite(self.torque).T
        torque = self.torque if self.offset is None else self.torque - self.offset
        return self.regressor.swapaxes(0, 1)[usable], torque.T[usable]

    def predicted_torque(self, parameters: Floats) -> Floats:
        """Torque (m, dof) [N m] predicted with `parameters` (k,)."""
        predicted: Floats = self.regressor @ parameters
        return predicted if self.offset is None else predicted + self.offset

    def residual(self, parameters: Floats) -> Floats:
        """Measured minus predicted torque (m, dof) [N m] with `parameters` (k,)."""
        return self.torque - self.predicted_torque(parameters)


def linearize(prepared: PreparedRecording, structure: ModelStructure, x: Floats) -> Regression:
    """Linearize the model `structure` at the parameters `x` (K,)."""
    if not structure.terms:
        return Regression.of_mechanism(prepared)
    torque, columns = chunks.linearized(prepared, structure, x)
    offset = torque - columns @ x[structure.linear] if structure.signals else None
    known = np.isfinite(columns).all(axis=2) & np.isfinite(torque)
    return Regression(prepared, columns, np.where(known, prepared.torque, np.nan), offset)
