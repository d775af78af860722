"""Predict the torque that the amplifiers report in a recording, and its derivatives with respect to the parameters.

    reported = condition(report_2(report_1(regressor . p + sum over effects of columns(shapes) . coefficients)))

for a motion that is corrected by the effects on encoders and rig. The measured torque is never modified, so that no
effect can reduce the error by scaling it down.
"""

from collections.abc import Callable, Hashable
from typing import TypeVar, cast

import numpy as np

from ident.data.prepared_recording import CorrectedMotion, PreparedRecording
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal, Values
from ident.dynamics.structure import ModelStructure, Term
from recordings.recording import Floats
from recordings.rig import Rig

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
        return self.prepared.condition(
            self._reported_torque(structure, x, self._load_parameters(structure, x, load_parameters))
        )

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
        derivatives = np.zeros((*self.prepared.dataset.torque.shape, len(x)))
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

    def columns(self, term: Term, shapes: Floats, corrected: CorrectedMotion, load_parameters: Floats) -> Floats:
        """(n, dof, instances * c) torque per unit of each coefficient of an additive `term`, instance by instance."""
        effect = term.effect
        assert isinstance(effect, Additive)
        values = dict(zip((shape.name for shape in effect.shapes), shapes.tolist(), strict=True))
        key = ("columns", term.name, tuple(shapes.tolist()), corrected, load_parameters.tobytes())
        columns = self._cached(key, lambda: effect.columns(self.effect_inputs(corrected, load_parameters), values))
        if effect.whole_robot:
            return columns
        n, dof, c = columns.shape
        by_joint = np.zeros((n, dof, len(term.joints), c))
        joints = list(term.joints)
        by_joint[:, joints, range(len(joints))] = columns[:, joints]
        return by_joint.reshape(n, dof, -1)

    def effect_inputs(self, corrected: CorrectedMotion, load_parameters: Floats) -> EffectInputs:
        """Inputs of effects for the load parameters (k or k + 1,) of a structure."""
        return self._cached(
            ("effect inputs", corrected, load_parameters.tobytes()),
            lambda: corrected.effect_inputs(
                self.prepared.samples.rate,
                self.prepared.time,
                self.prepared.preprocessed.bandwidth,
                load_parameters,
            ),
        )

    def corrected_motion(self, structure: ModelStructure, x: Floats) -> CorrectedMotion:
        """Motion and mechanism after the corrections of encoders and geometry given by `x` (K,)."""
        rig = self.prepared.as_recorded.rig
        corrections: list[Callable[[Floats], Floats]] = []
        key: list[Hashable] = ["corrected motion"]
        for index, term in enumerate(structure.terms):
            effect = term.effect
            if not isinstance(effect, Signal) or not (effect.position or effect.rig):
                continue
            values = structure.signal_values(index, x)
            key.append((term.name, *(tuple(value.tolist()) for value in values.values())))
            rig = effect.rig(rig, values) if effect.rig else rig
            if effect.position:
                corrections.append(position_correction(effect.position, rig, values))
        if len(key) == 1:
            return self.prepared.as_recorded

        def correct_all(measured: Floats) -> Floats:
            for correct in corrections:
                measured = correct(measured)
            return measured

        return self._cached(tuple(key), lambda: self.prepared.corrected_motion(rig, correct_all))

    def _load_parameters(self, structure: ModelStructure, x: Floats, load_parameters: Floats | None) -> Floats:
        return structure.load_parameters(x) if load_parameters is None else load_parameters

    def _all_columns(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(n, dof, K_linear) columns of all linear parameters, in the order of the vector."""
        corrected = self.corrected_motion(structure, x)
        effect_columns = [
            self.columns(term, structure.shape_values(index, x), corrected, load_parameters)
            for index, term in enumerate(structure.terms)
            if isinstance(term.effect, Additive)
        ]
        return np.concatenate([corrected.regressor, *effect_columns], axis=2)

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
        inputs = self.effect_inputs(self.corrected_motion(structure, x), load_parameters)
        for index, term in enumerate(structure.terms):
            if isinstance(term.effect, Signal) and term.effect.report:
                torque = term.effect.report(torque, inputs, structure.signal_values(index, x))
        return torque

    def _linear_derivatives(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(m, dof, K_linear) derivatives with respect to the linear parameters."""
        columns = self._all_columns(structure, x, load_parameters)
        if not any(isinstance(term.effect, Signal) and term.effect.report for term in structure.terms):
            return self.prepared.condition(columns)
        true: Floats = columns @ x[structure.linear]
        step = _RELATIVE_STEP * max(float(np.sqrt(np.nanmean(true**2))), 1e-12)
        if all(term.effect.pointwise for term in structure.terms if isinstance(term.effect, Signal)):
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
            return np.zeros_like(self.prepared.dataset.torque)
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


def position_correction(
    correct: Callable[[Floats, Rig, Values], Floats], rig: Rig, values: Values
) -> Callable[[Floats], Floats]:
    """Return the function from measured to true positions (n, dof) of an effect on encoders."""
    return lambda measured: correct(measured, rig, values)
