"""Predict the torque that the amplifiers report in a recording, and its derivatives with respect to the parameters.

    reported = condition(report_2(report_1(regressor . p + sum over effects of columns(shapes) . coefficients)))

for a motion that is corrected by the effects on encoders and rig. The measured torque is never modified, so that no
effect can reduce the error by scaling it down.
"""

from collections.abc import Callable, Hashable
from typing import TypeVar, cast

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.structure import ModelStructure
from recordings.recording import Floats

_T = TypeVar("_T")
_RELATIVE_STEP = 1e-4
"""Relative step of finite differences."""
CACHE_SIZE = 64
"""Default number of cached columns and corrected motions."""


class TorquePredictor:
    """Predicts the torque of one recording for any model structure, and caches expensive results."""

    def __init__(self, prepared: PreparedRecording, cache_size: int = CACHE_SIZE) -> None:
        self.prepared = prepared
        self._cache_size = cache_size
        self._cache: dict[Hashable, object] = {}
        self._last_torque: tuple[Hashable, Floats] | None = None

    def torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats | None = None) -> Floats:
        """Predict the reported torque (m, dof) [N m], conditioned as the measured torque, for parameters `x` (K,).

        load_parameters: (k or k + 1,) parameters from which effects compute the load; None: those in `x`.
        """
        load = structure.load_parameters(x) if load_parameters is None else load_parameters
        return self.prepared.condition(self._reported_torque(structure, x, load))

    def unfiltered(self, structure: ModelStructure, x: Floats) -> Floats:
        """Predict the reported torque (n, dof) [N m] before conditioning."""
        return self._reported_torque(structure, x, structure.load_parameters(x))

    def linearized(self, structure: ModelStructure, x: Floats, nonlinear: bool = True) -> tuple[Floats, Floats]:
        """Predict the reported torque (m, dof) at `x` (K,) and its derivatives (m, dof, K).

        nonlinear: whether to compute the derivatives with respect to nonlinear parameters, which are expensive; else
            they are 0.
        """
        load_parameters = structure.load_parameters(x)
        reported = self._reported_torque(structure, x, load_parameters)
        derivatives = np.zeros((*self.prepared.torque.shape, len(x)))
        derivatives[:, :, structure.linear] = self._linear_derivatives(structure, x, load_parameters)
        for entry in np.flatnonzero(~structure.linear) if nonlinear else ():
            derivatives[:, :, entry] = self._nonlinear_derivative(structure, x, load_parameters, int(entry), reported)
        return self.prepared.condition(reported), derivatives

    def error_amplification(self, structure: ModelStructure, x: Floats, error: Floats) -> Floats:
        """(n, dof) amplification of an `error` (dof,) of the true torque [N m] in the reported torque, at `x`."""
        load_parameters = structure.load_parameters(x)
        true = self._true_torque(structure, x, load_parameters)
        upper, lower = (self._report(structure, x, load_parameters, true + side * error) for side in (1, -1))
        slope: Floats = np.abs(upper - lower) / (2 * error)
        return slope

    def columns(self, structure: ModelStructure, index: int, x: Floats, load_parameters: Floats) -> Floats:
        """(n, dof, instances * c) torque per unit of each coefficient of the additive term `index`.

        The inputs of the effect are those of the whole `structure` at `x` (K,).
        """
        term, shapes = structure.terms[index], structure.shape_values(index, x).tobytes()
        key = ("columns", term.name, shapes, self.corrected_motion(structure, x), load_parameters.tobytes())

        def columns() -> Floats:
            return structure.columns(index, x, self.effect_inputs(structure, x, load_parameters))

        return term.by_instance(self._cached(key, columns))

    def effect_inputs(
        self, structure: ModelStructure, x: Floats, load_parameters: Floats | None = None
    ) -> EffectInputs:
        """Inputs of effects at `x` (K,); load_parameters: as in `torque`."""
        corrected = self.corrected_motion(structure, x)
        load = structure.load_parameters(x) if load_parameters is None else load_parameters
        prepared = self.prepared
        return self._cached(
            ("effect inputs", corrected, load.tobytes()),
            lambda: corrected.effect_inputs(
                prepared.samples.rate, prepared.instant_time, prepared.bandwidth, load, prepared.temperature
            ),
        )

    def corrected_motion(self, structure: ModelStructure, x: Floats) -> MechanismMotion:
        """Motion and mechanism after the corrections of encoders and geometry given by `x` (K,)."""
        key = tuple(
            (term.name, *(tuple(value.tolist()) for value in structure.signal_values(index, x).values()))
            for index, term, effect in structure.signals
            if effect.position or effect.rig
        )
        if not key:
            return self.prepared.as_recorded
        rig, corrections = structure.corrections(x)

        def correct_all(measured: Floats) -> Floats:
            for correct in corrections:
                measured = correct(measured)
            return measured

        return self._cached(("corrected motion", *key), lambda: self.prepared.corrected_motion(rig, correct_all))

    def _all_columns(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(n, dof, K_linear) columns of all linear parameters, in the order of the vector."""
        effect_columns = [
            self.columns(structure, index, x, load_parameters)
            for index, term in enumerate(structure.terms)
            if isinstance(term.effect, Additive)
        ]
        mechanism = structure.mechanism_columns(self.corrected_motion(structure, x).regressor)
        return np.concatenate([mechanism, *effect_columns], axis=2)

    def _reported_torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        return self._report(structure, x, load_parameters, self._true_torque(structure, x, load_parameters))

    def _true_torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(n, dof) true torque. The last result is cached, as most nonlinear parameters affect only the report."""
        additive = [
            (term.name, term.joints, structure.shape_values(index, x).tobytes())
            for index, term in enumerate(structure.terms)
            if isinstance(term.effect, Additive)
        ]
        key = (
            self.corrected_motion(structure, x),
            load_parameters.tobytes(),
            x[structure.linear].tobytes(),
            *additive,
        )
        if self._last_torque is None or self._last_torque[0] != key:
            true: Floats = self._all_columns(structure, x, load_parameters) @ x[structure.linear]
            true.flags.writeable = False
            self._last_torque = key, true
        return self._last_torque[1]

    def _report(self, structure: ModelStructure, x: Floats, load_parameters: Floats, torque: Floats) -> Floats:
        inputs = self.effect_inputs(structure, x, load_parameters)
        for _, report in structure.reports(x):
            torque = report(torque, inputs)
        return torque

    def _linear_derivatives(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(m, dof, K_linear) derivatives with respect to the linear parameters."""
        columns = self._all_columns(structure, x, load_parameters)
        if not any(effect.report for _, _, effect in structure.signals):
            return self.prepared.condition(columns)
        true: Floats = columns @ x[structure.linear]
        step = _RELATIVE_STEP * max(float(np.sqrt(np.nanmean(true**2))), 1e-12)
        if all(effect.pointwise for _, _, effect in structure.signals):
            upper, lower = (self._report(structure, x, load_parameters, true + side * step) for side in (1, -1))
            return self.prepared.condition(columns * ((upper - lower) / (2 * step))[:, :, None])
        slopes = []
        for column in np.moveaxis(columns, 2, 0):
            column_step = step / max(float(np.sqrt(np.nanmean(column**2))), 1e-12)
            upper, lower = (
                self._report(structure, x, load_parameters, true + side * column_step * column) for side in (1, -1)
            )
            slopes.append((upper - lower) / (2 * column_step))
        return self.prepared.condition(np.stack(slopes, axis=2))

    def _nonlinear_derivative(
        self, structure: ModelStructure, x: Floats, load_parameters: Floats, entry: int, reported: Floats
    ) -> Floats:
        """(m, dof) derivative with respect to a nonlinear parameter; 0 if the parameter is fixed.

        reported: (n, dof) reported torque at `x`.
        """
        parameter = structure.parameters[entry]
        if not parameter.free:
            return np.zeros_like(self.prepared.torque)
        step = structure.terms[parameter.term].effect.step * max(abs(x[entry]), parameter.scale)
        shifted = x.copy()
        shifted[entry] += step if x[entry] + step <= parameter.upper else -step
        difference = self._reported_torque(structure, shifted, load_parameters) - reported
        return self.prepared.condition(difference / (shifted[entry] - x[entry]))

    def _cached(self, key: Hashable, compute: Callable[[], _T]) -> _T:
        if key not in self._cache:
            if len(self._cache) >= self._cache_size:
                self._cache.pop(next(iter(self._cache)))
            self._cache[key] = compute()
        return cast(_T, self._cache[key])
