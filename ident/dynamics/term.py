"""An effect on some joints of a robot."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from ident.dynamics.effects.base import Effect, Quantity, Suggestion
from recordings.recording import Floats
from recordings.rig import Rig


@dataclass(frozen=True)
class Term:
    """An effect on some joints."""

    name: str
    effect: Effect
    joints: tuple[int, ...]
    """From 0; all of them for an effect of the whole robot."""

    @classmethod
    def on_all_joints(cls, name: str, effect: Effect, rig: Rig) -> "Term":
        """Return the term of `effect` on all joints of `rig` that can have it."""
        return cls(name, effect, effect.possible_joints(rig))

    @property
    def instances(self) -> int:
        """Number of sets of local parameters: one per joint, or one for the whole robot."""
        return 1 if self.effect.whole_robot else len(self.joints)

    @property
    def local_parameters(self) -> tuple[Quantity, ...]:
        """Parameters of each instance."""
        return self.effect.parameters

    @property
    def shapes(self) -> tuple[Quantity, ...]:
        """Its shape parameters: those of the effect, once or for each instance."""
        return self.effect.shapes * (self.instances if self.effect.local_shapes else 1)

    def shape_guesses(self, suggestions: Sequence[Suggestion]) -> list[Floats]:
        """Values (s,) of its `shapes` at which a fit starts, from the effect and from its `suggestions`."""
        effect = self.effect
        names = [shape.name for shape in effect.shapes]
        if suggestions and effect.merge is not None:
            suggestions = [effect.merge(suggestions)]
        suggested = [[suggestion[name] for name in names] for suggestion in suggestions]
        known = suggested and effect.local_shapes
        declared = () if known else product(*(shape.initial_guesses for shape in effect.shapes))
        return [self._shape_vector(values) for values in (*declared, *suggested)]

    def _shape_vector(self, values: Sequence[float | Floats]) -> Floats:
        """The `values` of its effect's shapes, numbers or (dof,), as values (s,) of its `shapes`."""
        if not self.effect.local_shapes:
            return np.array(values, float)
        by_joint = [np.asarray(value)[list(self.joints)] if np.ndim(value) else value for value in values]
        return np.stack([np.broadcast_to(value, self.instances) for value in by_joint], axis=1).astype(float).ravel()

    def by_instance(self, columns: Floats) -> Floats:
        """Columns (n, dof, instances * c) of all coefficients, from those (n, dof, c) that an additive effect has."""
        if self.effect.whole_robot:
            return columns
        n, dof, c = columns.shape
        by_joint = np.zeros((n, dof, self.instances, c))
        for instance, joint in enumerate(self.joints):
            by_joint[:, joint, instance] = columns[:, joint]
        return by_joint.reshape(n, dof, -1)

    def torque(self, columns: Floats, coefficients: Floats) -> Floats:
        """Torque (n, dof) of an additive effect with its `columns` (n, dof, c) and `coefficients` (instances, c)."""
        if self.effect.whole_robot:
            return columns @ coefficients[0]
        torque = np.zeros(columns.shape[:2])
        for joint, values in zip(self.joints, coefficients, strict=True):
            torque[:, joint] = columns[:, joint] @ values
        return torque
