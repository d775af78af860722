"""Which effects recordings can show: how large each must be to stand out, and which others would explain it as well.

The torque of an effect is visible as far as the base model cannot reproduce it. Its mean square must exceed what the
judge asks of evidence. Then the torque is planted in place of the residual and all other effects are screened for it:
those that leave nothing visible of it are its imitations on this motion.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from pydantic import Field

from ident.diagnosis.judge.equivalence import MIN_DECISIVE_REDUCTION, slack
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.judge import MIN_TORQUE_SHARE
from ident.diagnosis.judge.rules.limits import plausible_instances
from ident.diagnosis.search.initial_guesses import initial_guesses
from ident.diagnosis.search.review import MAX_ALTERNATIVES
from ident.diagnosis.search.screening import MIN_EXCITATION, Screener
from ident.dynamics.effects.base import Effect
from ident.dynamics.structure import Term
from recordings.config import ConfigSection
from recordings.recording import Bools, Floats, Ints

_TINY = 1e-12

Status = Literal["visible", "confusable", "not-visible"]


class SmallestSize(ConfigSection):
    """The size from which an effect shows."""

    share: float
    """RMS of its torque, relative to that of the joint."""
    parameter: str
    value: float
    unit: str


class Visibility(ConfigSection):
    """What the recordings can show of one effect."""

    effect: str
    status: Status
    joints: tuple[int, ...] = ()
    """Joints that show it, from 1; of the whole robot: all."""
    confusable_with: tuple[str, ...] = ()
    """Effects that would explain it as well, the closest first."""
    smallest: SmallestSize | None = None
    """On the joint that shows it best; None if no size that hardware has shows on this motion."""
    best_joint: int = Field(0, exclude=True)
    """That joint, from 0."""
    outside: float = Field(0.0, exclude=True)
    """RMS part of its torque there that the base model cannot reproduce, 0 to 1."""


@dataclass(frozen=True, eq=False)
class _Planted:
    """An effect at one initial guess: of each instance, the parameter that shows best."""

    numbers: Ints
    """(instances,) of that parameter among the local ones."""
    share: Floats
    """(instances,) RMS of the smallest visible torque, relative to that of the joint; infinite: none is possible."""
    size: Floats
    """(instances,) value of the parameter at that torque."""
    outside: Floats
    """(instances,) RMS part of the torque that the base model cannot reproduce."""
    torque: Floats
    """(r, instances) weighted rows of that part, where the RMS torque of the effect is that of the joint."""


class VisibilityCheck:
    """Judges effects beside one fitted base model, for torques of one `share` of that of the joint."""

    def __init__(self, model: FittedModel, library: Mapping[str, Effect], share: float) -> None:
        solution = model.solution
        self._split, self._rig, self._share = model.split, solution.structure.rig, share
        self._library = {name: effect for name, effect in library.items() if name not in model.names}
        self._screener = Screener(model.split, solution).with_residuals(solution.residuals)
        self._lengths = [len(weight) for weight in solution.weights]
        weights = np.concatenate(solution.weights)
        self._kept = weights > 0
        self._joint: Ints = np.nonzero(self._kept)[1]
        self._weight: Floats = weights[self._kept]
        self._noise: Floats = self._weight * np.maximum(model.noise_floor.rms, _TINY)[self._joint]

    def effects(self) -> list[Visibility]:
        """The visibility of every effect of the library that the base model lacks."""
        return [self._effect(Term.on_all_joints(*entry, self._rig)) for entry in self._library.items()]

    def _effect(self, term: Term) -> Visibility:
        guesses = initial_guesses(term, self._screener.suggestions(term.effect))
        if not guesses:
            return Visibility(effect=term.name, status="not-visible")
        planted = min((self._plant(term, *guess) for guess in guesses), key=lambda each: float(each.share.min()))
        best, visible = int(planted.share.argmin()), planted.share <= self._share
        quantity, joint = term.local_parameters[planted.numbers[best]], term.joints[best]
        torque = self._share * planted.torque[:, visible].sum(axis=1)
        imitations = self._imitations(term, torque) if visible.any() else ()
        return Visibility(
            effect=term.name,
            status="not-visible" if not visible.any() else "confusable" if imitations else "visible",
            joints=tuple((np.nonzero(self._owned(term)[visible].any(axis=0))[0] + 1).tolist()),
            confusable_with=imitations,
            smallest=SmallestSize(
                share=float(planted.share[best]),
                parameter=quantity.name,
                value=float(planted.size[best]),
                unit=quantity.unit_on(self._rig, joint),
            )
            if np.isfinite(planted.share[best])
            else None,
            best_joint=joint,
            outside=float(planted.outside[best]),
        )

    def _owned(self, term: Term) -> Bools:
        """(instances, dof) joints on which an instance of `term` acts."""
        joints = np.eye(self._rig.dof, dtype=bool)[list(term.joints)]
        return np.asarray(joints.any(axis=0, keepdims=True) if term.effect.whole_robot else joints)

    def _plant(self, term: Term, guess: Floats, shapes: Floats) -> _Planted:
        """The `term` with the local parameters `guess` (instances, c) and the `shapes` (s,)."""
        columns = self._screener.columns(term, guess, shapes)
        outside = self._screener.orthogonal(columns)
        quantities, owned = term.local_parameters, np.repeat(self._owned(term), guess.shape[1], axis=0)
        mine = owned[:, self._joint].T
        weight, noise = self._weight[:, None], self._noise[:, None]
        whole, left, in_floors = (
            np.maximum(_rms(rows, mine), _TINY) for rows in (columns / weight, outside / weight, outside / noise)
        )
        torque = np.maximum(np.sqrt(owned @ self._split.torque_rms**2 / owned.sum(axis=1)), _TINY)
        factor = np.maximum(np.sqrt(self._detectable(owned)) / in_floors, MIN_TORQUE_SHARE * torque / left)
        # A parameter without which another effect is left does not make this one what it is.
        proper = np.array([quantity.reduces_to is not None for quantity in quantities])
        limits = np.array([min(quantity.upper, term.effect.max_amplitude or np.inf) for quantity in quantities])
        size = factor * np.abs(guess.ravel())
        possible = (size.reshape(guess.shape) <= limits) & (proper | ~proper.any())
        share = np.where(possible.ravel() & (left > MIN_EXCITATION * whole + _TINY), factor * whole / torque, np.inf)
        numbers = np.where(np.isfinite(share), factor, np.inf).reshape(guess.shape).argmin(axis=1)
        best = np.arange(len(guess)) * guess.shape[1] + numbers
        return _Planted(
            numbers,
            share[best],
            size[best],
            (left / whole)[best],
            outside[:, best] * (torque / whole)[best],
        )

    def _detectable(self, owned: Bools) -> Floats:
        """(k,) mean square of a torque, in squared noise floors, that held-out rows of `owned` (k, dof) confirm.

        Per row of noise 1, a torque r changes the squared residual by r^2 +- 2 r: Student's t is r sqrt(n) / 2.
        """
        rows = np.maximum(owned @ self._split.independent(self._split.test), 1)
        return np.maximum((2 * MIN_T) ** 2 / rows, MIN_DECISIVE_REDUCTION)

    def _imitations(self, term: Term, torque: Floats) -> tuple[str, ...]:
        """Names of effects that leave nothing visible of the planted `torque` (r,) of `term`, and are equivalent."""
        residual = np.zeros(self._kept.shape)
        residual[self._kept] = torque / self._weight
        screener = self._screener.with_residuals(np.split(residual, np.cumsum(self._lengths)[:-1]))
        noise = float(self._noise @ self._noise)
        allowed = min(
            slack(screener.loss + noise, noise, self._split.independent_rows),
            noise * float(self._detectable(np.ones((1, self._rig.dof), bool))[0]),
        )
        others = {
            name: effect
            for name, effect in self._library.items()
            if name != term.name and term.name not in effect.contains
        }
        names = dict.fromkeys(
            candidate.term.name
            for candidate in screener.screen(others)[0]
            if candidate.loss <= allowed and all(plausible_instances(candidate.term, candidate.local_values))
        )
        return tuple(names)[:MAX_ALTERNATIVES]


def _rms(values: Floats, rows: Bools) -> Floats:
    """(k,) RMS of the columns `values` (r, k) over their `rows` (r, k)."""
    return np.asarray(np.sqrt((values**2 * rows).sum(axis=0) / np.maximum(rows.sum(axis=0), 1)))
