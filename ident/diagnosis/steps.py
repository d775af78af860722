"""The steps of a diagnosis: models on the way, what could be added to them, and what was found."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from ident.diagnosis.improvement import Gain
from ident.diagnosis.noise_floor import Floor
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import Solution
from recordings.recording import Floats

Unseen = Literal["imitated", "sign"]
"""imitated: other parameters make up all that it would change; sign: it would need one that it cannot have."""


@dataclass(frozen=True, eq=False)
class State:
    """A model on the way, with what it leaves."""

    solution: Solution
    residuals: tuple[Floats, ...]
    """(m, dof) of every recording."""

    @property
    def terms(self) -> tuple[Term, ...]:
        """Its effects."""
        return self.solution.composition.terms


@dataclass(frozen=True, eq=False)
class Options:
    """Beyond one model."""

    states: tuple[State, ...]
    """With one effect more, the best first."""
    unseen: Mapping[str, "Unseen"]
    """Effects that could not be looked at any further, and why."""
    gains: Mapping[str, float]
    """What each effect would gain at first sight, as a share of the loss."""


@dataclass(frozen=True, eq=False)
class Rung:
    """A step of the ladder."""

    added: str | None
    state: State
    gain: Gain | None


@dataclass(frozen=True, eq=False)
class Finding:
    """An effect of the final model."""

    term: Term
    gain: Gain
    """What leaving it out would cost on held-out rows."""
    alternatives: tuple[str, ...]
    """Other effects that would explain these data as well in its place, the closest first."""
    without: tuple[Floats, ...]
    """(m, dof) what the final model leaves of each recording without this effect, refitted [N m]."""
    with_it: tuple[Floats, ...]


@dataclass(frozen=True, eq=False)
class Ladder:
    """All that was found."""

    rungs: tuple[Rung, ...]
    findings: tuple[Finding, ...]
    first: Options
    """What could have been added first."""
    last: Options
    """What could be added still."""
    floor: Floor
    computed: tuple[Floats, ...]
    """(m, dof) torque of the final model on each recording [N m]."""
