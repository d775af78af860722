"""Two effects that could explain the same, beside a mechanism: which motion tells them apart.

The torque that one effect makes is fitted by the mechanism's parameters and the other effect together; what is left
of it is all that can speak against the other one. A motion is the better, the more is left (T-optimality).
"""

from dataclasses import dataclass, replace

import numpy as np

from ident import mechanisms
from ident.design.with_effects import view_of
from ident.effects import Additive, Effect, Signal
from ident.mechanisms import Mechanism, Parameter
from ident.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.rig import Rig

_RIDGE = 1e-9
"""Of the mean square of a column; makes matrices invertible."""


@dataclass(frozen=True)
class Rivals:
    """The mechanism of `rig` and two effects on all joints, as columns one behind the other."""

    rig: Rig
    base: Mechanism
    names: tuple[str, str]
    effects: tuple[Effect, Effect]

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """Of the mechanism, then a scale for each column of the effects."""
        pairs = zip(self.names, self.effects, strict=True)
        own = [
            Parameter(f"{name}.{number}", "1", f"strength of {name}")
            for name, effect in pairs
            for number in range(1, _count(effect, self.rig) + 1)
        ]
        return *self.base.parameters, *own

    @property
    def pointwise(self) -> bool:
        """Effects may remember."""
        return False

    def regressor(self, motion: Motion) -> Floats:
        """Columns (n, dof, k) of the mechanism, the first effect and the second."""
        rivals = [_columns(effect, motion, self.base, self.rig) for effect in self.effects]
        return np.concatenate([self.base.regressor(motion), *rivals], axis=2)

    def nominal_torque(self, motion: Motion) -> Floats | None:
        """The manufacturer's model knows no effects."""
        return self.base.nominal_torque(motion)

    def separation(self, rows: Floats) -> Floats:
        """(b, 2) for regressors (b, rows, k): share of each effect's torque that the rest cannot imitate.

        That is: of what the mechanism alone cannot imitate of it, what the other effect cannot either.
        """
        gram = rows.transpose(0, 2, 1) @ rows / rows.shape[1]
        own = len(self.base.parameters)
        first = own + _count(self.effects[0], self.rig)
        base, one, other = np.arange(own), np.arange(own, first), np.arange(first, rows.shape[2])
        shares = []
        for which, rival in ((one, other), (other, one)):
            alone = _left(gram, which, base)
            shares.append(_left(gram, which, np.concatenate([base, rival])) / np.maximum(alone, 1e-300))
        return np.stack(shares, axis=1)

    def told(self, rows: Floats) -> Floats:
        """(b,) the smaller of the mean squares of torque that speak for one effect against the other."""
        gram = rows.transpose(0, 2, 1) @ rows / rows.shape[1]
        own = len(self.base.parameters)
        first = own + _count(self.effects[0], self.rig)
        base, one, other = np.arange(own), np.arange(own, first), np.arange(first, rows.shape[2])
        both = [_left(gram, a, np.concatenate([base, b])) for a, b in ((one, other), (other, one))]
        return np.minimum(*both)


def rivals(rig: Rig, names: tuple[str, str], effects: tuple[Effect, Effect]) -> Rivals:
    """The mechanism of `rig` with two effects to tell apart.

    Raises:
        BadInput: an effect is none of this mechanism, or depends on when something happens.
    """
    for name, effect in zip(names, effects, strict=True):
        if rig.mechanism not in effect.mechanisms:
            raise BadInput(f"effect {name}: one of mechanism {rig.mechanism} expected; choose another")
        if effect.axis == "time":
            raise BadInput(
                f"effect {name}: one that depends on the motion expected, it depends on time; record longer instead"
            )
    if names[0] == names[1]:
        raise BadInput(f"two different effects expected, {names[0]} found twice; name another")
    return Rivals(rig, mechanisms.create(rig), names, effects)


def _count(effect: Effect, rig: Rig) -> int:
    own = effect.coefficients if isinstance(effect, Additive) else effect.parameters  # type: ignore[attr-defined]
    return len(own) * (1 if effect.whole_robot else rig.dof)


def _shapes(effect: Effect) -> dict[str, float]:
    return {shape.name: shape.starts[len(shape.starts) // 2] if shape.starts else 40.0 for shape in effect.shapes}


def _columns(effect: Effect, motion: Motion, base: Mechanism, rig: Rig) -> Floats:
    """Torque (n, dof, c) per strength of the effect, joint by joint."""
    view = view_of(rig, base, motion)
    if isinstance(effect, Additive):
        made = effect.columns(view, _shapes(effect))
        if effect.whole_robot:
            return made
        n, dof, c = made.shape
        spread = np.zeros((n, dof, dof, c))
        spread[:, range(dof), range(dof)] = made
        return spread.reshape(n, dof, dof * c)
    assert isinstance(effect, Signal)
    owners = [None] if effect.whole_robot else list(range(rig.dof))
    return np.stack(
        [
            _difference(effect, view.rigid, motion, base, rig, owner, i)
            for owner in owners
            for i in range(len(effect.parameters))
        ],
        axis=2,
    )


def _difference(
    effect: Signal, torque: Floats, motion: Motion, base: Mechanism, rig: Rig, owner: int | None, index: int
) -> Floats:
    """Change (n, dof) of what is reported, per strength of one parameter of a distortion, of the weight above all."""
    start = effect.parameters[index].starts[0]
    strength = np.zeros(1 if owner is None else rig.dof)
    strength[owner or 0] = start
    values = {one.name: np.zeros_like(strength) for one in effect.parameters}
    values[effect.parameters[index].name] = strength
    values |= {name: np.array([value]) for name, value in _shapes(effect).items()}
    true_rig = effect.rig(rig, values) if effect.rig else rig
    position = effect.position(motion.position, rig, values) if effect.position else motion.position
    view = view_of(true_rig, mechanisms.create(true_rig) if effect.rig else base, replace(motion, position=position))
    reported = effect.report(view.rigid, view, values) if effect.report else view.rigid
    change: Floats = np.nan_to_num((reported - torque) / start)
    return change


def _left(gram: Floats, which: Ints, rest: Ints) -> Floats:
    """(b,) mean square of the columns `which` that those of `rest` cannot imitate, given all products (b, k, k)."""
    own = gram[:, which[:, None], which]
    inner = gram[:, rest[:, None], rest]
    size = np.trace(inner, axis1=1, axis2=2) / len(rest)
    inner = inner + (_RIDGE * size)[:, None, None] * np.eye(len(rest))
    cross = gram[:, rest[:, None], which]
    taken = cross.transpose(0, 2, 1) @ np.linalg.solve(inner, cross)
    left: Floats = np.maximum(np.trace(own - taken, axis1=1, axis2=2), 1e-12 * np.trace(own, axis1=1, axis2=2))
    return left
