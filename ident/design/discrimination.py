"""Discrimination of effects by a motion (T-optimality).

The torque of one effect is fitted by the parameters of the mechanism and of an alternative effect together. Only the
unexplained rest of that torque is evidence against the alternative; the larger it is, the better is the motion. The
strength of an effect is not known in advance: it is normalized so that the mechanism alone leaves 1 N m of the
effect's torque unexplained on a reference motion. Recordings that exist are evaluated together with the new motion.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from ident.design.model import DesignModel, mandatory_effects, with_effects
from ident.dynamics.effects.base import Effect
from ident.dynamics.mechanisms import Parameter
from ident.dynamics.motion import Motion
from ident.dynamics.structure import Term
from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.rig import Rig

MIN_DISCRIMINABILITY = 1e-3
"""Minimum share of an effect's torque that no alternative explains; below it, effects are not distinguishable."""
_MIN_UNEXPLAINED = 1e-3
"""Lower limit of the unexplained share of an effect's torque on the reference motion, for the normalization."""
_RIDGE = 1e-9
"""Regularization that makes matrices invertible, relative to the mean square of a column."""

Pair = tuple[str, str]


@dataclass(frozen=True, eq=False)
class DiscriminationModel:
    """A mechanism and effects on all joints, as columns of one regressor."""

    base: DesignModel
    """The mechanism with the mandatory effects."""
    terms: Mapping[str, Term]
    """Effects to discriminate, by name, each on all joints."""
    pairs: tuple[Pair, ...]
    """Pairs of effects to discriminate."""
    joints: tuple[int, ...]
    """Possible joints of the true effect, from 0; alternatives may be on any joint."""
    strengths: Mapping[str, Floats] = field(default_factory=dict)
    """(instances,) strength of each effect; 1 if missing."""
    recorded_products: Floats | float = 0.0
    """(k, k) sum of the mean products of the columns on each recorded motion."""

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Parameters of the mechanism, then the strength of each column of the effects."""
        return *self.base.parameters, *(
            Parameter(f"{name}.{number + 1}", "1", f"strength of {name}")
            for name, term in self.terms.items()
            for number in range(term.instances * len(term.local_parameters))
        )

    def regressor(self, motion: Motion) -> Floats:
        """(n, dof, k) columns of the mechanism, then of one effect after the other."""
        effect_columns = [
            self.base.columns(term, motion) * np.repeat(self._strength(name), len(term.local_parameters))
            for name, term in self.terms.items()
        ]
        return np.concatenate([self.base.regressor(motion), *effect_columns], axis=2)

    def at_rate(self, rate: float) -> "DiscriminationModel":
        """Return the model for motions at `rate` [Hz]."""
        return replace(self, base=replace(self.base, rate=rate))

    def normalized_on(self, motion: Motion) -> "DiscriminationModel":
        """Return the model with effects of which the mechanism leaves 1 N m RMS unexplained on `motion`.

        Raises:
            BadInput: an effect has no torque in that motion.
        """
        gram = products(self.regressor(motion)[None])
        strengths = {}
        for name, term in self.terms.items():
            instances = [self._columns(name, instance) for instance in range(term.instances)]
            whole = np.array([gram[0, columns, columns].sum() for columns in instances])
            if not whole.any():
                raise BadInput(
                    f"effect {name}: a torque in a motion expected, but it needs a load and the load of rig "
                    f"'{self.base.structure.rig.name}' is not known; name a recording: --recording FILE"
                )
            unexplained = np.array([_unexplained(gram, columns, self._base_columns)[0] for columns in instances])
            rms = np.sqrt(np.maximum(unexplained, _MIN_UNEXPLAINED**2 * whole))
            strengths[name] = self._strength(name) / np.where(rms > 0, rms, 1.0)
        return replace(self, strengths=strengths)

    def with_recorded(self, motion: Motion) -> "DiscriminationModel":
        """Return the model for motions that will be evaluated together with the recorded `motion`."""
        return replace(self, recorded_products=self.recorded_products + products(self.regressor(motion)[None])[0])

    def unexplained(self, gram: Floats) -> dict[str, Floats]:
        """(b, q) mean squares of each effect's torque that an alternative leaves unexplained.

        gram: (b, k, k) mean products of the columns.
        q: each alternative, with the true effect on each of the joints.
        """
        gram = gram + self.recorded_products
        mean_squares: dict[str, list[Floats]] = {}
        for name, columns, alternative in self._comparisons():
            mean_squares.setdefault(name, []).append(_unexplained(gram, columns, alternative))
        return {name: np.stack(values, axis=1) for name, values in mean_squares.items()}

    def discriminability(self, columns: Floats) -> dict[str, float]:
        """Least RMS of each effect's unexplained torque, given the `columns` (n, dof, k) of the regressor."""
        mean_squares = self.unexplained(products(columns[None]))
        return {name: float(np.sqrt(values.min())) for name, values in mean_squares.items()}

    @cached_property
    def _base_columns(self) -> Ints:
        """Indices of the columns of the mechanism."""
        return np.arange(len(self.base.parameters))

    def _comparisons(self) -> Iterator[tuple[str, Ints, Ints]]:
        """Yield each true effect, its columns on one joint, and the columns of mechanism and alternative.

        An effect that the alternative contains as a special case is skipped: the alternative explains it completely.
        """
        for pair in self.pairs:
            for true, alternative in (pair, pair[::-1]):
                if true in self.terms[alternative].effect.contains:
                    continue
                columns = np.concatenate([self._base_columns, self._columns(alternative)])
                for instance in self._true_instances(self.terms[true]):
                    yield true, self._columns(true, instance), columns

    def _true_instances(self, term: Term) -> tuple[int, ...]:
        """Instances of a true effect on the possible joints."""
        if term.effect.whole_robot:
            return (0,)
        return tuple(term.joints.index(joint) for joint in self.joints if joint in term.joints)

    def _columns(self, name: str, instance: int | None = None) -> Ints:
        """Indices of the columns of an effect: all, or those of one instance."""
        first = len(self._base_columns)
        for key, term in self.terms.items():
            if key == name:
                break
            first += term.instances * len(term.local_parameters)
        size = len(self.terms[name].local_parameters)
        if instance is None:
            return np.arange(first, first + self.terms[name].instances * size)
        return np.arange(first + instance * size, first + (instance + 1) * size)

    def _strength(self, name: str) -> Floats:
        return self.strengths.get(name, np.ones(self.terms[name].instances))


def discrimination_model(
    rig: Rig,
    pairs: Sequence[Pair],
    effects: Mapping[str, Effect],
    joints: Sequence[int] = (),
    parameters: Floats | None = None,
    *,
    torque_measured: bool = False,
) -> DiscriminationModel:
    """Build the model of the mechanism of `rig` with the effects of all `pairs` to discriminate.

    effects: by name; they include those of the pairs.
    joints: possible joints of the true effect, from 0; empty: all.
    parameters: (k,) of the mechanism with its mandatory effects; None: those of the rig file.
    torque_measured: recordings contain the torque itself, not a voltage.

    Raises:
        BadInput: an effect is unknown, not of this mechanism, depends on time, or is not observable in recordings of
            this rig; or a joint does not exist.
    """
    for first, second in pairs:
        for name in (first, second):
            _check_effect(name, effects, rig, torque_measured)
        if first == second:
            raise BadInput(f"two different effects expected, {first} found twice; name another effect")
    if any(joint >= rig.dof for joint in joints):
        raise BadInput(f"joint 1 to {rig.dof} expected, {max(joints) + 1} found; name another joint")
    selected = list(dict.fromkeys(name for pair in pairs for name in pair))
    base = with_effects(rig, [name for name in mandatory_effects(rig) if name not in selected])
    base = base if parameters is None else base.with_parameters(parameters[: len(base.parameters)])
    return DiscriminationModel(
        base,
        {name: Term.on_all_joints(name, effects[name], rig) for name in selected},
        tuple(pairs),
        tuple(joints) or tuple(range(rig.dof)),
    )


def _check_effect(name: str, effects: Mapping[str, Effect], rig: Rig, torque_measured: bool) -> None:
    if name not in effects:
        raise BadInput(f"effect: one of {', '.join(effects)} expected, '{name}' found; name one of them")
    effect = effects[name]
    if rig.mechanism not in effect.mechanisms:
        raise BadInput(f"effect {name}: an effect of mechanism {rig.mechanism} expected; choose another")
    if effect.axis == "time":
        raise BadInput(
            f"effect {name}: an effect that depends on the motion expected, it depends on time; record longer instead"
        )
    if reason := effect.why_unobservable(rig, torque_measured, temperature_measured=False):
        raise BadInput(
            f"effect {name}: an effect that is observable in recordings of this rig expected: {reason.rstrip('.')}; "
            "choose another"
        )


def products(columns: Floats) -> Floats:
    """(b, k, k) mean products of the `columns` (b, ..., k)."""
    rows = columns.reshape(len(columns), -1, columns.shape[-1])
    return rows.transpose(0, 2, 1) @ rows / rows.shape[1]


def _unexplained(gram: Floats, columns: Ints, explaining: Ints) -> Floats:
    """(b,) mean square of `columns` that the columns `explaining` leave in a least-squares fit; gram: (b, k, k)."""
    whole = gram[:, columns, columns].sum(axis=1)
    inner = gram[:, explaining[:, None], explaining]
    size = np.sqrt(np.diagonal(inner, axis1=1, axis2=2))
    size = np.where(size > 0, size, 1.0)
    inner = inner / (size[:, :, None] * size[:, None, :]) + _RIDGE * np.eye(len(explaining))
    cross = gram[:, explaining[:, None], columns] / size[:, :, None]
    explained = np.einsum("brw,brw->b", cross, np.linalg.solve(inner, cross))
    return np.maximum(whole - explained, 1e-12 * whole)
