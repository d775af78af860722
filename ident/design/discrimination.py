"""Effects that could explain the same, beside a mechanism: which motion tells them apart.

The torque that one effect makes is fitted by the mechanism's parameters and a rival effect together; what is left of
it is all that can speak against the rival. A motion is the better, the more is left (T-optimality). How strong an
effect is, nobody knows: each is taken to be so strong that the mechanism alone leaves 1 N m of it on a motion of
reference. Where there is a recording, the new one will be looked at together with it, and so it is here.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ident.design.columns import EffectContext
from ident.design.with_effects import nominal_parameters, with_effects
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import load, names
from ident.dynamics.mechanisms import Mechanism, Parameter
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.rig import Rig

MIN_DISCRIMINABILITY = 1e-3
"""Share of an effect's torque that no rival may imitate; with less, no motion tells them apart."""
_SHOWN = 1e-3
"""Share of its torque that an effect leaves on the motion of reference, or it is taken to be no stronger."""
_RIDGE = 1e-9
"""Of the mean square of a column; makes matrices invertible."""

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class DiscriminationModel:
    """A mechanism, and effects on all joints, as columns one behind the other."""

    context: EffectContext
    """With what is true of any such machine in its mechanism."""
    effects: Mapping[str, Effect]
    pairs: tuple[Pair, ...]
    """Which effects are to be told apart."""
    joints: tuple[int, ...]
    """Where the true one is, from 0; its rivals may be anywhere."""
    strengths: Mapping[str, Floats] = field(default_factory=dict)
    """(owners,) of each effect; 1 where it is missing."""
    recorded_products: Floats | float = 0.0
    """(k, k) mean products of the columns on motions that are recorded already."""

    @property
    def base(self) -> Mechanism:
        """Without the effects."""
        return self.context.mechanism

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Of the mechanism, then a scale for each column of the effects."""
        return *self.base.parameters, *(
            Parameter(f"{name}.{number + 1}", "1", f"strength of {name}")
            for name, effect in self.effects.items()
            for number in range(self.context.parameter_count(effect))
        )

    @property
    def pointwise(self) -> bool:
        """Effects may remember."""
        return False

    def regressor(self, motion: Motion) -> Floats:
        """Columns (n, dof, k) of the mechanism, then of one effect after the other."""
        own = [
            self.context.columns(effect, motion) * np.repeat(self._strength(name), self.context.parameters_per_instance(effect))
            for name, effect in self.effects.items()
        ]
        return np.concatenate([self.base.regressor(motion), *own], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """The manufacturer's model knows no effects."""
        return self.base.nominal_torque(motion)

    def at_rate(self, rate: float) -> "DiscriminationModel":
        """For motions at `rate` [Hz]."""
        return replace(self, setting=replace(self.context, rate=rate))

    def normalized_on(self, motion: Motion) -> "DiscriminationModel":
        """With effects of which the mechanism leaves 1 N m RMS on `motion`, on whichever joint they are.

        Raises:
            BadInput: an effect makes no torque there.
        """
        gram = products(self.regressor(motion)[None])
        strengths = {}
        for name, effect in self.effects.items():
            owners = [self._entries(name, owner) for owner in range(self.context.instances(effect))]
            whole = np.array([gram[0, which, which].sum() for which in owners])
            if not whole.any():
                raise BadInput(
                    f"effect {name}: one that makes a torque in a motion expected, it needs a load, and that of rig "
                    f"'{self.context.rig.name}' is not known; name a recording: --recording FILE"
                )
            left = np.array([_left(gram, which, self._own)[0] for which in owners])
            shown = np.sqrt(np.maximum(left, _SHOWN**2 * whole))
            strengths[name] = self._strength(name) / np.where(shown > 0, shown, 1.0)
        return replace(self, strengths=strengths)

    def with_recorded(self, motion: Motion) -> "DiscriminationModel":
        """For motions that will be looked at together with `motion`, which is recorded already."""
        return replace(self, recorded=self.recorded_products + products(self.regressor(motion)[None])[0])

    def unexplained(self, gram: Floats) -> dict[str, Floats]:
        """(b, q) of each effect: mean squares of torque that speak for it, given mean products (b, k, k) of columns.

        q: against each rival, on each of the joints.
        """
        gram = gram + self.recorded_products
        found: dict[str, list[Floats]] = {}
        for name, which, rest in self._questions():
            found.setdefault(name, []).append(_left(gram, which, rest))
        return {name: np.stack(values, axis=1) for name, values in found.items()}

    def discriminability(self, columns: Floats) -> dict[str, float]:
        """The least RMS of torque that speaks for each effect, of `columns` (n, dof, k) of the regressor."""
        told = self.unexplained(products(columns[None]))
        return {name: float(np.sqrt(values.min())) for name, values in told.items()}

    @cached_property
    def _own(self) -> Ints:
        """The columns of the mechanism."""
        return np.arange(len(self.base.parameters))

    def _questions(self) -> Iterator[tuple[str, Ints, Ints]]:
        """An effect, its columns on one joint, and those of all that may imitate it there.

        Nothing can speak for what its rival contains as a special case, but that it is simpler.
        """
        for pair in self.pairs:
            for true, rival in (pair, pair[::-1]):
                if true in self.effects[rival].contains:
                    continue
                rest = np.concatenate([self._own, self._entries(rival)])
                for owner in (0,) if self.effects[true].whole_robot else self.joints:
                    yield true, self._entries(true, owner), rest

    def _entries(self, name: str, owner: int | None = None) -> Ints:
        """The columns of an effect, all or those of one joint."""
        first = len(self._own)
        for other, effect in self.effects.items():
            if other == name:
                break
            first += self.context.parameter_count(effect)
        effect, each = self.effects[name], self.context.parameters_per_instance(self.effects[name])
        if owner is None:
            return np.arange(first, first + self.context.parameter_count(effect))
        return np.arange(first + owner * each, first + (owner + 1) * each)

    def _strength(self, name: str) -> Floats:
        return self.strengths.get(name, np.ones(self.context.instances(self.effects[name])))


def discrimination_model(
    rig: Rig,
    pairs: Sequence[Pair],
    effects: Mapping[str, Effect],
    joints: Sequence[int] = (),
    parameters: Floats | None = None,
    *,
    torque_measured: bool = False,
) -> DiscriminationModel:
    """The mechanism of `rig` with effects of which each of the `pairs` is to be told apart.

    effects: by name, those of the pairs among them.
    joints: where the true one is, from 0; empty: nobody knows.
    known: (k,) parameters of the mechanism with what is always true of it; those of the rig file if None.
    torque_measured: recordings hold the torque itself, and no voltage.

    Raises:
        BadInput: an effect is unknown or none of this mechanism, depends on when something happens, or leaves no
            trace in recordings of this rig; or there is no such joint.
    """
    for first, second in pairs:
        for name in (first, second):
            _refuse(name, effects, rig, torque_measured)
        if first == second:
            raise BadInput(f"two different effects expected, {first} found twice; name another")
    if any(joint >= rig.dof for joint in joints):
        raise BadInput(f"joint 1 to {rig.dof} expected, {max(joints) + 1} found; name another")
    named = list(dict.fromkeys(name for pair in pairs for name in pair))
    base = with_effects(rig, [name for name in mandatory_effects(rig) if name not in named])
    values = nominal_parameters(rig, base) if parameters is None else parameters[: len(base.parameters)]
    return DiscriminationModel(
        EffectContext(rig, base, values),
        {name: effects[name] for name in named},
        tuple(pairs),
        tuple(joints) or tuple(range(rig.dof)),
    )


def mandatory_effects(rig: Rig) -> list[str]:
    """Effects that every machine of this kind shows."""
    return [name for name in names() if (effect := load(name)).mandatory and rig.mechanism in effect.mechanisms]


def _refuse(name: str, effects: Mapping[str, Effect], rig: Rig, torque_measured: bool) -> None:
    if name not in effects:
        raise BadInput(f"effect: one of {', '.join(effects)} expected, '{name}' found; name another")
    effect = effects[name]
    if rig.mechanism not in effect.mechanisms:
        raise BadInput(f"effect {name}: one of mechanism {rig.mechanism} expected; choose another")
    if effect.axis == "time":
        raise BadInput(
            f"effect {name}: one that depends on the motion expected, it depends on time; record longer instead"
        )
    if why := effect.unobservable(rig, torque_measured):
        raise BadInput(
            f"effect {name}: one that recordings of this rig can show expected: {why.rstrip('.')}; choose another"
        )


def products(columns: Floats) -> Floats:
    """(b, k, k) mean products of columns (b, ..., k)."""
    rows = columns.reshape(len(columns), -1, columns.shape[-1])
    gram: Floats = rows.transpose(0, 2, 1) @ rows / rows.shape[1]
    return gram


def _left(gram: Floats, which: Ints, rest: Ints) -> Floats:
    """(b,) mean square of the columns `which` that those of `rest` cannot imitate, given all products (b, k, k)."""
    whole = gram[:, which, which].sum(axis=1)
    inner = gram[:, rest[:, None], rest]
    size = np.sqrt(np.diagonal(inner, axis1=1, axis2=2))
    size = np.where(size > 0, size, 1.0)
    inner = inner / (size[:, :, None] * size[:, None, :]) + _RIDGE * np.eye(len(rest))
    cross = gram[:, rest[:, None], which] / size[:, :, None]
    taken = np.einsum("brw,brw->b", cross, np.linalg.solve(inner, cross))
    left: Floats = np.maximum(whole - taken, 1e-12 * whole)
    return left
