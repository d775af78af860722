"""What climbing the ladder leaves behind: models on the way, and what was found."""

from collections.abc import Mapping
from dataclasses import dataclass

from ident.composition import Term
from ident.diagnose.evidence import Gain
from ident.diagnose.floor import Floor
from ident.refine import Solution
from recordings.recording import Floats


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
    unseen: tuple[str, ...]
    """Effects that this motion does not excite."""
    first_gains: Mapping[str, float]
    """What each candidate would have gained first, as a share of the loss."""
    last_gains: Mapping[str, float]
    """What each one that was not added would still gain at the end."""
    floor: Floor
    computed: tuple[Floats, ...]
    """(m, dof) torque of the final model on each recording [N m]."""
