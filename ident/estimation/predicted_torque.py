"""What a composition says that the amplifiers of one recording report, and how that depends on its parameters.

    reported = condition(report_2(report_1(regressor . p + sum over effects of columns(shapes) . coefficients)))

on a path that is corrected by the effects on encoders and rig. What is compared is always the torque as it was
recorded, so that no effect can lower the error by making the measured torque smaller.
"""

from collections.abc import Callable, Hashable
from typing import TypeVar, cast

import numpy as np

from ident.data.prepared_recording import PreparedRecording, CorrectedMotion
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal, Values
from ident.dynamics.structure import ModelStructure, Term
from recordings.recording import Floats
from recordings.rig import Rig

_T = TypeVar("_T")
_RELATIVE_STEP = 1e-4
"""Of differences that stand for derivatives, over the size of what is changed."""
CACHE_SIZE = 64
"""Columns and paths that are remembered."""


class TorquePredictor:
    """Evaluates compositions on one recording, and remembers what was expensive."""

    def __init__(self, course: PreparedRecording, remembered: int = CACHE_SIZE) -> None:
        self.prepared = course
        self._kept = remembered
        self._known: dict[Hashable, object] = {}
        self._last: tuple[Hashable, Floats] | None = None

    def torque(self, composition: ModelStructure, x: Floats, rigid: Floats | None = None) -> Floats:
        """Reported torque (m, dof) [N m], conditioned as the measured one was, for the parameters `x` (K,).

        rigid: (k or k + 1,) by what effects reckon the load; as in `x` if None.
        """
        return self.prepared.condition(self._reported(composition, x, self._own(composition, x, rigid)))

    def unfiltered(self, composition: ModelStructure, x: Floats) -> Floats:
        """The same (n, dof) as `torque`, before it is conditioned."""
        return self._reported(composition, x, composition.load_parameters(x))

    def linearized(self, composition: ModelStructure, x: Floats, nonlinear: bool = True) -> tuple[Floats, Floats]:
        """Reported torque (m, dof) at `x` (K,), and its derivatives (m, dof, K).

        searched: whether those by the searched parameters are wanted, which take longest; else they are 0.
        """
        own = composition.load_parameters(x)
        here = self._reported(composition, x, own)
        derivatives = np.zeros((*self.prepared.dataset.torque.shape, len(x)))
        derivatives[:, :, composition.linear] = self._solved(composition, x, own)
        for entry in np.flatnonzero(~composition.linear) if nonlinear else ():
            derivatives[:, :, entry] = self._searched(composition, x, own, int(entry), here)
        return self.prepared.condition(here), derivatives

    def error_amplification(self, composition: ModelStructure, x: Floats, error: Floats) -> Floats:
        """(n, dof) how many times larger an `error` (dof,) of the torque [N m] is in the report, at `x` (K,)."""
        rigid = composition.load_parameters(x)
        true = self._true(composition, x, rigid)
        more, less = (self._report(composition, x, rigid, true + side * error) for side in (1, -1))
        slope: Floats = np.abs(more - less) / (2 * error)
        return slope

    def columns(self, term: Term, shapes: Floats, path: CorrectedMotion, rigid: Floats) -> Floats:
        """(n, dof, owners * c) torque per unit of each coefficient of an additive `term`, owner by owner."""
        effect = term.effect
        assert isinstance(effect, Additive)
        values = dict(zip((shape.name for shape in effect.shapes), shapes.tolist(), strict=True))
        key = ("columns", term.name, tuple(shapes.tolist()), path, rigid.tobytes())
        made = self._remembered(key, lambda: effect.columns(self.effect_inputs(path, rigid), values))
        if effect.whole_robot:
            return made
        n, dof, c = made.shape
        spread = np.zeros((n, dof, len(term.joints), c))
        joints = list(term.joints)
        spread[:, joints, range(len(joints))] = made[:, joints]
        return spread.reshape(n, dof, -1)

    def effect_inputs(self, path: CorrectedMotion, rigid: Floats) -> EffectInputs:
        """What effects see, with the load `rigid` (k or k + 1,) of a composition."""
        return self._remembered(("view", path, rigid.tobytes()), lambda: path.effect_inputs(self.prepared, rigid))

    def corrected_motion(self, composition: ModelStructure, x: Floats) -> CorrectedMotion:
        """What the machine did, if its encoders and its lengths are as `x` (K,) says."""
        rig = self.prepared.as_recorded.rig
        corrections: list[Callable[[Floats], Floats]] = []
        key: list[Hashable] = ["path"]
        for index, term in enumerate(composition.terms):
            effect = term.effect
            if not isinstance(effect, Signal) or not (effect.position or effect.rig):
                continue
            values = self.signal_values(composition, index, x)
            key.append((term.name, *(tuple(value.tolist()) for value in values.values())))
            rig = effect.rig(rig, values) if effect.rig else rig
            if effect.position:
                corrections.append(_correction(effect.position, rig, values))
        if len(key) == 1:
            return self.prepared.as_recorded

        def true(measured: Floats) -> Floats:
            for correct in corrections:
                measured = correct(measured)
            return measured

        return self._remembered(tuple(key), lambda: self.prepared.corrected_motion(rig, true))

    def signal_values(self, composition: ModelStructure, index: int, x: Floats) -> Values:
        """What the signal effect that is the term `index` is evaluated with."""
        term = composition.terms[index]
        found = composition.local_values(index, x)
        if not term.effect.whole_robot:
            spread = np.zeros((composition.rig.dof, found.shape[1]))
            spread[list(term.joints)] = found
            found = spread
        own = {one.name: found[:, i] for i, one in enumerate(term.local_parameters)}
        shapes = composition.shape_values(index, x)
        return {**own, **{one.name: shapes[i : i + 1] for i, one in enumerate(term.effect.shapes)}}

    def _own(self, composition: ModelStructure, x: Floats, rigid: Floats | None) -> Floats:
        return composition.load_parameters(x) if rigid is None else rigid

    def _all_columns(self, composition: ModelStructure, x: Floats, rigid: Floats) -> Floats:
        """(n, dof, K_linear) in the order of the vector."""
        path = self.corrected_motion(composition, x)
        added = [
            self.columns(term, composition.shape_values(index, x), path, rigid)
            for index, term in enumerate(composition.terms)
            if isinstance(term.effect, Additive)
        ]
        return np.concatenate([path.regressor, *added], axis=2)

    def _reported(self, composition: ModelStructure, x: Floats, rigid: Floats) -> Floats:
        return self._report(composition, x, rigid, self._true(composition, x, rigid))

    def _true(self, composition: ModelStructure, x: Floats, rigid: Floats) -> Floats:
        """(n, dof) torque before it is reported; the last is kept, as most searched parameters are of reports."""
        additive = [
            (term.name, term.joints, composition.shape_values(index, x).tobytes())
            for index, term in enumerate(composition.terms)
            if isinstance(term.effect, Additive)
        ]
        key = (self.corrected_motion(composition, x), rigid.tobytes(), x[composition.linear].tobytes(), *additive)
        if self._last is None or self._last[0] != key:
            true: Floats = self._all_columns(composition, x, rigid) @ x[composition.linear]
            true.flags.writeable = False
            self._last = key, true
        return self._last[1]

    def _report(self, composition: ModelStructure, x: Floats, rigid: Floats, torque: Floats) -> Floats:
        view = self.effect_inputs(self.corrected_motion(composition, x), rigid)
        for index, term in enumerate(composition.terms):
            if isinstance(term.effect, Signal) and term.effect.report:
                torque = term.effect.report(torque, view, self.signal_values(composition, index, x))
        return torque

    def _solved(self, composition: ModelStructure, x: Floats, rigid: Floats) -> Floats:
        """(m, dof, K_linear) derivatives by the linear parameters."""
        columns = self._all_columns(composition, x, rigid)
        if not any(isinstance(term.effect, Signal) and term.effect.report for term in composition.terms):
            return self.prepared.condition(columns)
        true: Floats = columns @ x[composition.linear]
        step = _RELATIVE_STEP * max(float(np.sqrt(np.nanmean(true**2))), 1e-12)
        if all(term.effect.pointwise for term in composition.terms if isinstance(term.effect, Signal)):
            ahead, behind = (self._report(composition, x, rigid, true + side * step) for side in (1, -1))
            return self.prepared.condition(columns * ((ahead - behind) / (2 * step))[:, :, None])
        slopes = []
        for column in np.moveaxis(columns, 2, 0):
            small = step / max(float(np.sqrt(np.nanmean(column**2))), 1e-12)
            ahead, behind = (self._report(composition, x, rigid, true + side * small * column) for side in (1, -1))
            slopes.append((ahead - behind) / (2 * small))
        return self.prepared.condition(np.stack(slopes, axis=2))

    def _searched(self, composition: ModelStructure, x: Floats, rigid: Floats, entry: int, here: Floats) -> Floats:
        """(m, dof) derivative by a searched parameter; 0 where it is not to be refined.

        here: (n, dof) what is reported at `x`.
        """
        one = composition.parameters[entry]
        if not one.free:
            return np.zeros_like(self.prepared.dataset.torque)
        step = composition.terms[one.term].effect.step * max(abs(x[entry]), one.scale)
        aside = x.copy()
        aside[entry] += step if x[entry] + step <= one.upper else -step
        difference = self._reported(composition, aside, rigid) - here
        return self.prepared.condition(difference / (aside[entry] - x[entry]))

    def _remembered(self, key: Hashable, make: Callable[[], _T]) -> _T:
        if key not in self._known:
            if len(self._known) >= self._kept:
                self._known.pop(next(iter(self._known)))
            self._known[key] = make()
        return cast(_T, self._known[key])


def _correction(
    correct: Callable[[Floats, Rig, Values], Floats], rig: Rig, values: Values
) -> Callable[[Floats], Floats]:
    return lambda measured: correct(measured, rig, values)
