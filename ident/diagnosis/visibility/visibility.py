"""Which effects recordings can show: how large each must be to stand out, and which others would explain it as well.

The torque of an effect is visible as far as the base model cannot reproduce it. That part must exceed the noise floor
by what a diagnosis asks of evidence. Then the torque is planted in place of the residual and all other effects are
screened for it: those that explain as much of it are its imitations on this motion.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_T
from ident.diagnosis.judge.price import MIN_DECISIVE_REDUCTION, PRICE, slack
from ident.diagnosis.judge.rules.limits import plausible_instances
from ident.diagnosis.search.screening import MIN_EXCITATION, Screener
from ident.diagnosis.search.selection import WIDTH
from ident.diagnosis.split.noise_floor import MIN_TORQUE_SHARE
from ident.dynamics.effects.base import Effect, Quantity
from ident.dynamics.structure import Term
from recordings.recording import Bools, Floats

MIN_FLOOR_RATIO = 0.3
"""The visible part of a torque must exceed this share of the noise floor, which is known to some ten percent."""


@dataclass(frozen=True)
class SmallestSize:
    """The size from which an effect shows; infinite if it never does."""

    share: float
    """RMS of its torque, relative to that of the joint."""
    parameter: str
    value: float
    unit: str


@dataclass(frozen=True)
class JointVisibility:
    """How well an effect shows on one joint, or on the whole robot."""

    joint: int | None
    """From 0; None: the whole robot."""
    smallest: SmallestSize
    outside: float
    """RMS part of its torque that the base model cannot reproduce, 0 to 1."""
    possible: bool
    """False if hardware never has the effect as large."""
    torque: Floats = field(default_factory=lambda: np.zeros(0), repr=False)
    """(r,) that part, in all rows, of a torque of the effect as large as that of the joint [N m]."""


@dataclass(frozen=True)
class EffectVisibility:
    """What recordings can show of one effect."""

    name: str
    joints: tuple[JointVisibility, ...]
    imitations: tuple[str, ...]
    """Effects that would explain it as well, the closest first."""

    def visible_joints(self, share: float) -> tuple[JointVisibility, ...]:
        """Joints that show the effect if its torque is this `share` of that of the joint."""
        return tuple(joint for joint in self.joints if joint.smallest.share <= share and joint.possible)

    @property
    def best(self) -> JointVisibility:
        """The joint on which the effect shows best."""
        return min(self.joints, key=lambda joint: (not joint.possible, joint.smallest.share))


class VisibilityCheck:
    """Judges effects beside one fitted base model."""

    def __init__(self, model: FittedModel, library: Mapping[str, Effect]) -> None:
        solution = model.solution
        self._split, self._rig = model.split, solution.structure.rig
        self._library = {name: effect for name, effect in library.items() if name not in model.names}
        self._screener = Screener(model.split, solution).with_residuals(solution.residuals)
        self._weights = solution.weights
        self._weight: Floats = np.concatenate([weight[weight > 0] for weight in self._weights])
        self._joint = np.concatenate([np.nonzero(weight > 0)[1] for weight in self._weights])
        floor: Floats = np.maximum(model.noise_floor.rms, np.finfo(float).eps)
        self._floor: Floats = floor[self._joint]

    def effects(self, share: float) -> Iterator[EffectVisibility]:
        """Yield every effect of the library that the base model lacks, judged for torques of this `share`."""
        for name, effect in self._library.items():
            term = Term.on_all_joints(name, effect, self._rig)
            planted = [EffectVisibility(name, self._joints(term, each), ()) for each in self._planted_shapes(term)]
            alone = min(planted, key=lambda each: min(joint.smallest.share for joint in each.joints))
            torques = [share * joint.torque for joint in alone.visible_joints(share)]
            yield replace(alone, imitations=self._imitations(name, np.sum(torques, axis=0))) if torques else alone

    def _planted_shapes(self, term: Term) -> list[Floats]:
        """Shapes (s,) with which a `term` is planted: typical ones, and every value of those that are an index.

        Those of the joints are what the data suggest.
        """
        effect = term.effect
        if effect.local_shapes:
            return term.shape_guesses(self._screener.suggestions(effect))
        choices = product(*map(self._typical, effect.shapes, effect.typical_shapes))
        return [np.array(shapes, float) for shapes in choices]

    def _typical(self, shape: Quantity, value: float) -> tuple[float, ...]:
        """Values of a shape parameter at which its effect is judged; `value`: the typical one."""
        if not shape.searched:
            return shape.initial_guesses or (shape.upper,)
        if shape.unit != "s":
            return (value,)
        middle = max(float(np.nanmax(data.time)) for data in self._split.recordings) / 2
        guesses = [guess for guess in shape.initial_guesses if guess > 0]
        return (min(guesses, key=lambda guess: abs(np.log(guess / middle)), default=middle),)

    def _joints(self, term: Term, shapes: Floats) -> tuple[JointVisibility, ...]:
        """Visibility on each joint by the parameter that shows best, of those that make the effect what it is."""
        quantities = term.local_parameters
        sizes = self._screener.guess_scales(term) * [quantity.first_guess for quantity in quantities]
        columns = self._screener.columns(term, sizes, shapes)
        torques = np.stack([columns, self._screener.orthogonal(columns)]) / self._weight[:, None]
        torques = torques.reshape(2, len(self._weight), term.instances, len(quantities))
        proper = [number for number, quantity in enumerate(quantities) if quantity.reduces_to]
        return tuple(
            min(
                (
                    self._smallest(term, joint, number, sizes[instance, number], torques[:, :, instance, number])
                    for number in proper or range(len(quantities))
                ),
                key=lambda judged: judged.smallest.value,
            )
            for instance, joint in enumerate((None,) if term.effect.whole_robot else term.joints)
        )

    def _smallest(self, term: Term, joint: int | None, number: int, guess: float, torques: Floats) -> JointVisibility:
        """The smallest visible size of the local parameter `number` on a `joint`, as a multiple of a `guess`.

        torques: (2, r) torque of the guess, and its part that the base model cannot reproduce [N m].
        """
        quantity = term.local_parameters[number]
        rows = np.ones_like(self._joint, bool) if joint is None else self._joint == joint
        whole, visible = _rms(torques[0, rows]), _rms(torques[1, rows])
        torque_rms = self._split.torque_rms if joint is None else self._split.torque_rms[joint]
        torque, factor = max(_rms(torque_rms), np.finfo(float).eps), np.inf
        share = whole / torque
        if visible > MIN_EXCITATION * whole:
            in_floors = _rms(torques[1, rows] / self._floor[rows])
            factor = max(self._required_ratio(term, joint) / in_floors, MIN_TORQUE_SHARE * torque / visible)
        size = factor * abs(float(guess))
        return JointVisibility(
            joint=joint,
            smallest=SmallestSize(
                share=factor * share if np.isfinite(factor) else np.inf,
                parameter=quantity.name,
                value=size,
                unit=quantity.unit_on(self._rig, joint or 0),
            ),
            outside=visible / whole if whole else 0.0,
            possible=size <= min(quantity.upper, term.effect.max_amplitude or np.inf),
            torque=torques[1] / share if share else torques[1],
        )

    def _required_ratio(self, term: Term, joint: int | None) -> float:
        """RMS of a visible torque, in units of the noise floor, that training rows and test rows would confirm.

        Per row of noise 1, a torque r changes the squared residual by r^2 +- 2 r: Student's t is r sqrt(n) / 2.
        """
        parameters = len(term.local_parameters) + sum(shape.searched for shape in term.shapes)
        train, test = (self._independent(rows, joint) for rows in (self._split.train, self._split.test))
        return float(np.sqrt(max(PRICE * parameters / train, (2 * MIN_T) ** 2 / test, MIN_FLOOR_RATIO**2)))

    def _independent(self, rows: Sequence[Bools], joint: int | None = None) -> float:
        """Equivalent number of independent ones among the `rows` (m, dof), at least 1; None: of all joints."""
        counts = self._split.independent(rows)
        return max(float(counts.sum() if joint is None else counts[joint]), 1.0)

    def _imitations(self, name: str, torque: Floats) -> tuple[str, ...]:
        """Names of effects that explain the `torque` (r,) of the effect `name` as well."""
        residuals = [np.zeros(weight.shape) for weight in self._weights]
        ends = np.cumsum([np.count_nonzero(weight > 0) for weight in self._weights])
        for residual, weight, part in zip(residuals, self._weights, np.split(torque, ends[:-1]), strict=True):
            residual[weight > 0] = part
        screener = self._screener.with_residuals(residuals)
        noise = float(((self._weight * self._floor) ** 2).sum())
        # What an effect may leave of the planted torque, without being ruled out by it.
        equivalent = slack(screener.loss + noise, noise, self._split.independent_rows)
        indecisive = noise * max(MIN_DECISIVE_REDUCTION, (2 * MIN_T) ** 2 / self._independent(self._split.test))
        screening = screener.screen(
            {other: each for other, each in self._library.items() if other != name and name not in each.contains}
        )
        names = [
            candidate.term.name
            for candidate in screening.candidates
            if candidate.loss <= min(equivalent, indecisive)
            and all(plausible_instances(candidate.term, candidate.local_values))
        ]
        return tuple(dict.fromkeys(names))[:WIDTH]


def _rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2))) if np.size(values) else 0.0
