"""Predict the torque that the amplifiers report in a recording, and its derivatives with respect to the parameters.

    reported = condition(report_2(report_1(regressor . p + sum over effects of columns(shapes) . coefficients)))

for a motion that is corrected by the effects on encoders and rig. The measured torque is never modified, so that no
effect can reduce the error by scaling it down.
"""

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import cast

import numpy as np

from ident.basics.recent import RecentResults
from ident.basics.threads import in_threads
from ident.data.prepared_recording import PreparedRecording
from ident.dynamics.effect_inputs import EffectInputs, WatchedInputs
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.mechanism_motion import MechanismMotion
from ident.dynamics.structure import ModelStructure
from recordings.recording import Floats

_RELATIVE_STEP = 1e-4
"""Relative step of finite differences."""
_ROUNDING = 1e-12
"""Relative differences below this are rounding errors."""
CACHE_SIZE = 64
"""Default number of cached columns and corrected motions."""
_CACHED_VALUES = 9_000_000
"""Number of cached columns and corrected motions, times that of joints and of instants of all recordings."""
_CACHE_SIZES = (8, 256)
"""Least and largest number of cached columns and corrected motions of each recording."""
_FREE_OF_LOAD = frozenset(
    {"rig", "rate", "time", "motion", "bandwidth", "platform", "temperature", "torque_per_mass", "beyond"}
)
"""Inputs of effects that do not depend on the parameters of the mechanism."""


@dataclass(frozen=True, eq=False)
class _Columns:
    """Columns (n, dof, c), and the same as conditioned by `prepared`, which are computed once."""

    raw: Floats
    prepared: PreparedRecording

    @cached_property
    def conditioned(self) -> Floats:
        """(m, dof, c)."""
        return self.prepared.condition(self.raw)


def cache_size(recordings: Sequence[PreparedRecording]) -> int:
    """Number of columns and corrected motions of each of the `recordings` for which there is memory."""
    values = sum(recording.preprocessed.motion.position.size for recording in recordings)
    return int(np.clip(_CACHED_VALUES / values, *_CACHE_SIZES))


def _is_linear(structure: ModelStructure) -> bool:
    """Whether the torque is linear in all parameters; an effect on a measurement may have none."""
    return bool(structure.linear.all()) and not structure.signals


class TorquePredictor:
    """Predicts the torque of one recording for any model structure, and caches expensive results."""

    def __init__(self, prepared: PreparedRecording, cache_size: int = CACHE_SIZE) -> None:
        self.prepared = prepared
        self._cache_size = cache_size
        self._cache = RecentResults(cache_size)
        self._last_torque: tuple[Hashable, Floats] | None = None

    def __reduce__(self) -> tuple[type["TorquePredictor"], tuple[PreparedRecording, int]]:
        """Pickle without the results, which are computed again where they are needed."""
        return TorquePredictor, (self.prepared, self._cache_size)

    def torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats | None = None) -> Floats:
        """Predict the reported torque (m, dof) [N m], conditioned as the measured torque, for parameters `x` (K,).

        load_parameters: parameters from which effects compute the load; None: those in `x`.
        """
        load = structure.load_parameters(x) if load_parameters is None else load_parameters
        if _is_linear(structure) and not self.prepared.moved:  # then few models need the torque, and none the columns
            return self._linear_model(structure, x, load)[0]
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
        if _is_linear(structure):
            return self._linear_model(structure, x, load_parameters)
        true = self._true_torque(structure, x, load_parameters)
        reported = self._report(structure, x, load_parameters, true)
        derivatives = np.zeros((*self.prepared.torque.shape, len(x)))
        derivatives[:, :, structure.linear] = self._linear_derivatives(structure, x, load_parameters, true)
        if nonlinear:
            entries = np.flatnonzero(~structure.linear).tolist()
            derive = partial(self._nonlinear_derivative, structure, x, load_parameters, true, reported)
            for entry, derivative in zip(entries, in_threads(derive, entries), strict=True):
                derivatives[:, :, entry] = derivative
        return self.prepared.condition(reported), derivatives

    def _linear_model(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> tuple[Floats, Floats]:
        """Torque and derivatives as `linearized` has them, where the torque is linear in `x` (K,).

        Columns at full rate, which take much memory, are not needed.
        """
        columns = self._all_columns(structure, x, load_parameters, conditioned=True)
        return np.einsum("mjk,k->mj", columns, x), columns

    def error_amplification(self, structure: ModelStructure, x: Floats, error: Floats) -> Floats:
        """(n, dof) amplification of an `error` (dof,) of the true torque [N m] in the reported torque, at `x`.

        An error below the step of finite differences is replaced by it.
        """
        load_parameters = structure.load_parameters(x)
        true = self._true_torque(structure, x, load_parameters)
        error = np.maximum(error, _RELATIVE_STEP * np.sqrt(np.nanmean(true**2, axis=0)))
        upper, lower = (self._report(structure, x, load_parameters, true + side * error) for side in (1, -1))
        return np.abs(upper - lower) / (2 * error)

    def conditioned_columns(
        self, structure: ModelStructure, index: int, x: Floats, load_parameters: Floats
    ) -> Floats:
        """(m, dof, instances * c) conditioned torque per unit of each coefficient of the additive term `index`.

        The inputs of the effect are those of the whole `structure` at `x` (K,).
        """
        columns = self._term_columns(structure, index, x, load_parameters)
        return structure.terms[index].by_instance(columns.conditioned)

    def _term_columns(self, structure: ModelStructure, index: int, x: Floats, load_parameters: Floats) -> _Columns:
        """(n, dof, c) columns of the additive term `index`; cached for all loads if they do not depend on them."""
        effect = structure.terms[index].effect
        assert isinstance(effect, Additive)
        shapes = np.array([*structure.shapes_by_name(index, x).values()]).tobytes()
        # The function, not the name: curves that are learned one after the other have the same name.
        key = ("columns", effect.columns, shapes, self.corrected_motion(structure, x))
        key_with_load = (*key, load_parameters.tobytes())
        for known in (key, key_with_load):
            if (columns := self._cache.find(known)) is not None:
                return cast(_Columns, columns)
        used: set[str] = set()
        inputs = WatchedInputs.of(self.effect_inputs(structure, x, load_parameters), used.add)
        computed = _Columns(structure.columns(index, x, inputs), self.prepared)
        return self._cache.keep(key if used <= _FREE_OF_LOAD else key_with_load, computed)

    def effect_inputs(
        self, structure: ModelStructure, x: Floats, load_parameters: Floats | None = None
    ) -> EffectInputs:
        """Inputs of effects at `x` (K,); load_parameters: as in `torque`."""
        corrected = self.corrected_motion(structure, x)
        load = structure.load_parameters(x) if load_parameters is None else load_parameters
        prepared = self.prepared

        def inputs() -> EffectInputs:
            rigid, arm_load_at, payload = structure.load(load)
            return corrected.effect_inputs(
                prepared.samples.rate,
                prepared.instant_time,
                prepared.bandwidth,
                rigid,
                prepared.temperature,
                prepared.end,
                arm_load_at,
                payload,
            )

        on_arms = tuple((structure.terms[index].name, structure.terms[index].joints) for index in structure.arm_terms)
        return self._cache.get(("effect inputs", corrected, load.tobytes(), on_arms), inputs)

    def recorded_inputs(self, structure: ModelStructure, x: Floats) -> EffectInputs:
        """The same at the rows (m,) of the recording, along the motion as it was recorded."""
        inputs = self.effect_inputs(structure, x)
        return replace(inputs, motion=self.prepared.motion, time=self.prepared.time)

    def corrected_motion(self, structure: ModelStructure, x: Floats) -> MechanismMotion:
        """Motion and mechanism after the corrections of encoders and geometry given by `x` (K,)."""
        key = tuple(
            (term.name, *(tuple(value.tolist()) for value in structure.signal_values(index, x).values()))
            for index, term, effect in structure.signals
            if effect.corrects_motion
        )
        if not key:
            return self.prepared.as_recorded
        rig, corrections = structure.corrections(x, self.prepared.recording.rig)

        def correct_all(measured: Floats) -> Floats:
            for correct in corrections:
                measured = correct(measured)
            return measured

        return self._cache.get(("corrected motion", *key), lambda: self.prepared.corrected_motion(rig, correct_all))

    def _all_columns(
        self, structure: ModelStructure, x: Floats, load_parameters: Floats, conditioned: bool
    ) -> Floats:
        """(n or m, dof, K_linear) columns of all linear parameters, in the order of the vector."""
        motion = self.corrected_motion(structure, x)
        if conditioned:
            mechanism = self._cache.get(("mechanism", motion), lambda: self.prepared.columns(motion))
        else:
            mechanism = motion.regressor
        columns = [structure.mechanism_columns(mechanism)]
        for index, term, _ in structure.additive:
            of_term = self._term_columns(structure, index, x, load_parameters)
            columns.append(term.by_instance(of_term.conditioned if conditioned else of_term.raw))
        return np.concatenate(columns, axis=2)

    def _reported_torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        return self._report(structure, x, load_parameters, self._true_torque(structure, x, load_parameters))

    def _true_torque(self, structure: ModelStructure, x: Floats, load_parameters: Floats) -> Floats:
        """(n, dof) true torque. The last result is cached, as most nonlinear parameters affect only the report."""
        corrected = self.corrected_motion(structure, x)
        key = (
            corrected,
            load_parameters.tobytes(),
            x[structure.linear].tobytes(),
            *(
                (effect.columns, term.joints, structure.shape_values(index, x).tobytes())
                for index, term, effect in structure.additive
            ),
        )
        last = self._last_torque
        if last is None or last[0] != key:
            true = corrected.torque(structure.mechanism_values(x[structure.linear])).copy()
            for index, term, _ in structure.additive:
                columns = self._term_columns(structure, index, x, load_parameters).raw
                true += term.torque(columns, structure.local_values(index, x))
            true.flags.writeable = False
            self._last_torque = last = key, true
        return last[1]

    def _report(self, structure: ModelStructure, x: Floats, load_parameters: Floats, torque: Floats) -> Floats:
        inputs = self.effect_inputs(structure, x, load_parameters)
        beyond = inputs.torque_beyond if inputs.beyond else 0.0  # the drives report this torque, too
        for _, report in structure.reports(x):
            torque = report(torque + beyond, inputs) - beyond
        return torque

    def _linear_derivatives(
        self, structure: ModelStructure, x: Floats, load_parameters: Floats, true: Floats
    ) -> Floats:
        """(m, dof, K_linear) derivatives with respect to the linear parameters; `true`: (n, dof) true torque."""
        if not any(effect.distorts_report for _, _, effect in structure.signals):
            return self._all_columns(structure, x, load_parameters, conditioned=True)
        columns = self._all_columns(structure, x, load_parameters, conditioned=False)
        inputs = self.effect_inputs(structure, x, load_parameters)
        torque = true + inputs.torque_beyond if inputs.beyond else true
        for term, report in structure.reports(x):
            if cast(Signal, term.effect).pointwise:
                step = _RELATIVE_STEP * max(float(np.sqrt(np.nanmean(torque**2))), 1e-12)
                slope = (report(torque + step, inputs) - report(torque - step, inputs)) / (2 * step)
                columns = columns * slope[:, :, None]
            else:
                columns = report(columns, inputs)
            torque = report(torque, inputs)
        return self.prepared.condition(columns)

    def _nonlinear_derivative(
        self,
        structure: ModelStructure,
        x: Floats,
        load_parameters: Floats,
        true: Floats,
        reported: Floats,
        entry: int,
    ) -> Floats:
        """(m, dof) derivative with respect to a nonlinear parameter; 0 if the parameter is fixed.

        true, reported: (n, dof) torque at `x`.
        """
        parameter = structure.parameters[entry]
        if not parameter.free:
            return np.zeros_like(self.prepared.torque)
        effect = structure.terms[parameter.term].effect
        step = effect.step * max(abs(x[entry]), parameter.scale)
        shifted = x.copy()
        shifted[entry] += step if x[entry] + step <= parameter.upper else -step
        if effect.linear or effect.corrects_motion:
            true = self._true_torque(structure, shifted, load_parameters)
        difference = self._report(structure, shifted, load_parameters, true) - reported
        if np.nanmax(np.abs(difference), initial=0.0) < _ROUNDING * np.nanmax(np.abs(reported), initial=0.0):
            difference *= 0.0  # a search would follow its direction as far as it can
        return self.prepared.condition(difference / (shifted[entry] - x[entry]))
