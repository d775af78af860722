"""Which effects recordings can show: how large each must be to stand out, and which others would explain it as well.

The torque of an effect is visible as far as the base model cannot reproduce it. That part must exceed the noise floor
by what a diagnosis asks of evidence. Then the torque is planted in place of the residual and all other effects are
screened for it: those that explain as much of it are its imitations on this motion.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ident.diagnosis.judge.equivalence import EQUIVALENT_SHARE, MIN_DECISIVE_REDUCTION
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.judge import MIN_TORQUE_SHARE
from ident.diagnosis.judge.price import PRICE
from ident.diagnosis.judge.rules.limits import plausible_instances
from ident.diagnosis.search.screening import MIN_EXCITATION, Screener
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Effect, Quantity, Signal
from ident.dynamics.structure import Term
from recordings.recording import Bools, Floats, Ints

MIN_FLOOR_RATIO = 0.3
"""The visible part of a torque must exceed this share of the noise floor, which is known to some ten percent."""
MAX_IMITATIONS = 4
"""Number of imitations that are named."""
_TINY = 1e-12


@dataclass(frozen=True)
class JointVisibility:
    """The smallest size at which an effect shows on one joint, or on the whole robot."""

    joint: int | None
    """From 0; None: the whole robot."""
    share: float
    """RMS of the smallest visible torque of the effect, relative to the torque; infinite if none is visible."""
    outside: float
    """RMS part of its torque that the base model cannot reproduce, 0 to 1."""
    parameter: str
    unit: str
    size: float
    """Value of this parameter at the smallest visible size."""
    possible: bool
    """False if hardware never has the effect as large."""


@dataclass(frozen=True)
class EffectVisibility:
    """What recordings can show of one effect."""

    name: str
    effect: Effect
    joints: tuple[JointVisibility, ...]
    imitations: tuple[str, ...]
    """Effects that would explain it as well, the closest first."""

    def visible_joints(self, share: float) -> tuple[JointVisibility, ...]:
        """Joints that show the effect if its torque is this `share` of that of the joint."""
        return tuple(joint for joint in self.joints if joint.share <= share and joint.possible)

    @property
    def best(self) -> JointVisibility:
        """The joint on which the effect shows best."""
        return min(self.joints, key=lambda joint: (not joint.possible, joint.share))


@dataclass(frozen=True, eq=False)
class _Planted:
    """Weighted columns (r, instances * c) of an effect at one guess of its parameters."""

    term: Term
    guess: Floats
    """(instances, c) local parameters; 1 for coefficients."""
    columns: Floats
    outside: Floats
    """(r, instances * c) part of the columns that the base model cannot reproduce."""


class VisibilityCheck:
    """Judges effects beside one fitted base model."""

    def __init__(self, split: SplitData, model: FittedModel, library: Mapping[str, Effect]) -> None:
        solution = model.solution
        self._split, self._library, self._weights = split, library, solution.weights
        self._rig = solution.structure.rig
        self._present = {term.name for term in model.terms}
        self._screener = Screener(split, solution).with_residuals(solution.residuals)
        self._floor = np.maximum(model.noise_floor.rms, _TINY)
        kept = [weight > 0 for weight in solution.weights]
        self._joint: Ints = np.concatenate(
            [np.broadcast_to(np.arange(rows.shape[1]), rows.shape)[rows] for rows in kept]
        )
        self._weight: Floats = np.concatenate(
            [weight[rows] for weight, rows in zip(solution.weights, kept, strict=True)]
        )

    def effects(self, share: float) -> list[EffectVisibility]:
        """The visibility of every effect of the library that the base model lacks, for torques of this `share`."""
        return [
            self._effect(name, effect, share) for name, effect in self._library.items() if name not in self._present
        ]

    def _effect(self, name: str, effect: Effect, share: float) -> EffectVisibility:
        judged = [(planted, self._joints(planted)) for planted in self._plant(name, effect)]
        planted, joints = min(judged, key=lambda pair: min(joint.share for joint in pair[1]))
        visibility = EffectVisibility(name, effect, joints, ())
        if not visibility.visible_joints(share):
            return visibility
        return EffectVisibility(name, effect, joints, self._imitations(planted, visibility, share))

    def _plant(self, name: str, effect: Effect) -> list[_Planted]:
        """The effect with typical shapes; with every value of those that are an index."""
        term = Term.on_all_joints(name, effect, self._rig)
        signal = isinstance(effect, Signal)
        sizes = [quantity.initial_guesses[0] if signal else 1.0 for quantity in term.local_parameters]
        guess = np.tile(np.array(sizes), (term.instances, 1))
        planted = []
        for shapes in self._planted_shapes(term):
            columns = self._screener.columns(term, guess, shapes)
            planted.append(_Planted(term, guess, columns, self._screener.orthogonal(columns)))
        return planted

    def _planted_shapes(self, term: Term) -> list[Floats]:
        """Shapes (s,) with which a `term` is planted; those of the joints are what the data suggest."""
        effect = term.effect
        if effect.local_shapes:
            return term.shape_guesses(self._screener.suggestions(effect))
        choices = [
            self._typical(shape, value) for shape, value in zip(effect.shapes, effect.typical_shapes, strict=True)
        ]
        return [np.array(shapes, float) for shapes in product(*choices)]

    def _typical(self, shape: Quantity, value: float) -> tuple[float, ...]:
        """Values of a shape parameter at which its effect is judged; `value`: the typical one."""
        if not shape.searched:
            return shape.initial_guesses or (shape.upper,)
        if shape.unit != "s":
            return (value,)
        middle = max(float(np.nanmax(data.time)) for data in self._split.recordings) / 2
        guesses = [guess for guess in shape.initial_guesses if guess > 0]
        return (min(guesses, key=lambda guess: abs(np.log(guess / middle)), default=middle),)

    def _joints(self, planted: _Planted) -> tuple[JointVisibility, ...]:
        term = planted.term
        owners = (None,) if term.effect.whole_robot else term.joints
        return tuple(self._joint_visibility(planted, i, owner) for i, owner in enumerate(owners))

    def _joint_visibility(self, planted: _Planted, instance: int, joint: int | None) -> JointVisibility:
        """Visibility on one joint of the parameter that shows best, of those that make the effect what it is."""
        quantities = planted.term.local_parameters
        proper = [number for number, quantity in enumerate(quantities) if quantity.reduces_to]
        required, rows = self._required_ratio(planted.term, joint), self._rows(joint)
        by_guess: dict[float, JointVisibility] = {}
        for number in proper or range(len(quantities)):
            column = instance * len(quantities) + number
            whole, outside = (
                columns[rows, column] / self._weight[rows] for columns in (planted.columns, planted.outside)
            )
            size, visible, torque = _rms(whole), _rms(outside), self._torque(joint)
            factor = np.inf
            if visible > MIN_EXCITATION * size:
                in_floors = _rms(outside / self._floor[self._joint[rows]])
                factor = max(required / in_floors, MIN_TORQUE_SHARE * torque / visible)
            by_guess[factor] = self._sized(planted, instance, number, joint, factor, size / torque, visible)
        return by_guess[min(by_guess)]

    def _sized(
        self,
        planted: _Planted,
        instance: int,
        number: int,
        joint: int | None,
        factor: float,
        share: float,
        visible: float,
    ) -> JointVisibility:
        """The local parameter `number` of an `instance`, at `factor` times the guess that was planted.

        share, visible: RMS of the planted torque, relative to that of the joint; and of its visible part [N m].
        """
        quantity, effect = planted.term.local_parameters[number], planted.term.effect
        size = factor * abs(float(planted.guess[instance, number]))
        whole = share * self._torque(joint)
        return JointVisibility(
            joint=joint,
            share=factor * share if np.isfinite(factor) else np.inf,
            outside=visible / whole if whole else 0.0,
            parameter=quantity.name,
            unit=quantity.unit_on(self._rig, joint or 0),
            size=size,
            possible=size <= min(quantity.upper, effect.max_amplitude or np.inf),
        )

    def _required_ratio(self, term: Term, joint: int | None) -> float:
        """RMS of a visible torque, in units of the noise floor, that training rows and test rows would confirm.

        Per row of noise 1, a torque r changes the squared residual by r^2 +- 2 r: Student's t is r sqrt(n) / 2.
        """
        parameters = len(term.local_parameters) + sum(shape.searched for shape in term.shapes)
        train, test = (self._independent_rows(rows, joint) for rows in (self._split.train, self._split.test))
        return float(np.sqrt(max(PRICE * parameters / train, (2 * MIN_T) ** 2 / test, MIN_FLOOR_RATIO**2)))

    def _independent_rows(self, rows: Sequence[Bools], joint: int | None) -> float:
        """Equivalent number of independent `rows` (m, dof) of a joint: a low-pass correlates neighbours."""
        counts = [
            (selected if joint is None else selected[:, joint]).sum() * min(1.0, 2 * data.bandwidth / data.rate)
            for selected, data in zip(rows, self._split.recordings, strict=True)
        ]
        return max(float(sum(counts)), 1.0)

    def _rows(self, joint: int | None) -> Bools:
        """(r,) rows of the joint."""
        rows: Bools = np.ones(len(self._joint), bool) if joint is None else self._joint == joint
        return rows

    def _torque(self, joint: int | None) -> float:
        """RMS torque of the joint, or of all [N m]."""
        torque = self._split.torque_rms
        return max(_rms(torque) if joint is None else float(torque[joint]), _TINY)

    def _imitations(self, planted: _Planted, visibility: EffectVisibility, share: float) -> tuple[str, ...]:
        """Names of effects that explain the planted torque as well, where it is visible."""
        torque = np.zeros(len(self._joint))
        quantities = planted.term.local_parameters
        visible = visibility.visible_joints(share)
        for instance, joint in enumerate(visibility.joints):
            if joint not in visible:
                continue
            column = instance * len(quantities) + [quantity.name for quantity in quantities].index(joint.parameter)
            rows = self._rows(joint.joint)
            unit = _rms(planted.columns[rows, column] / self._weight[rows]) / self._torque(joint.joint)
            torque += planted.outside[:, column] * share / unit
        screener = self._screener.with_residuals(self._unstacked(torque / self._weight))
        others = {
            name: effect
            for name, effect in self._library.items()
            if name not in (visibility.name, *self._present) and visibility.name not in effect.contains
        }
        allowed = self._indecisive_loss(screener.loss)
        candidates = [
            candidate
            for candidate in screener.screen(others)[0]
            if candidate.loss <= allowed and all(plausible_instances(candidate.term, candidate.local_values))
        ]
        return tuple(dict.fromkeys(candidate.term.name for candidate in candidates))[:MAX_IMITATIONS]

    def _indecisive_loss(self, loss: float) -> float:
        """What an effect may leave of the `loss` of a planted torque without being ruled out by it."""
        noise = float(((self._weight * self._floor[self._joint]) ** 2).sum())
        equivalent = max(EQUIVALENT_SHARE * loss, PRICE * noise / self._split.independent_rows)
        test = self._independent_rows(self._split.test, None)
        return min(equivalent, noise * max(MIN_DECISIVE_REDUCTION, (2 * MIN_T) ** 2 / test))

    def _unstacked(self, torque: Floats) -> list[Floats]:
        """(m, dof) of each training recording, from the stacked rows (r,)."""
        residuals, first = [], 0
        for weight in self._weights:
            residual = np.zeros(weight.shape)
            count = int((weight > 0).sum())
            residual[weight > 0] = torque[first : first + count]
            residuals.append(residual)
            first += count
        return residuals


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0
