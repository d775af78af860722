"""Where a climb by hand is: its recordings, its ladder, and the rungs that need not be fitted again."""

from dataclasses import dataclass, field
from pathlib import Path

from ident.diagnosis.diagnosis import Question
from ident.diagnosis.steps import Rung, State
from ident.diagnosis.stepwise_selection import Climber
from ident.workbench.views import Kept

_REMEMBERED = 16
"""Rungs that need not be fitted again when the page goes back to them."""


@dataclass(frozen=True, eq=False)
class Step:
    """A rung, and what was done to get there."""

    label: str
    rung: Rung

    @property
    def kept(self) -> Kept:
        """What it can be made again from."""
        terms = tuple((term.name, tuple(joint + 1 for joint in term.joints)) for term in self.rung.state.terms)
        return self.label, terms, tuple(self.rung.state.solution.x.tolist())


@dataclass(eq=False)
class Climb:
    """Recordings, and the present ladder on them."""

    files: tuple[Path, Path | None]
    asked: Question
    climber: Climber
    steps: tuple[Step, ...] = ()
    known: dict[tuple[Kept, ...], Step] = field(default_factory=dict)
    """Rungs, by the ladder that leads there."""
    diagnosed: State | None = None
    """The model that the full diagnosis ended with."""

    @property
    def state(self) -> State:
        """The present model."""
        return self.steps[-1].rung.state

    @property
    def kept(self) -> tuple[Kept, ...]:
        """The ladder, as it can be made again."""
        return tuple(step.kept for step in self.steps)

    def go(self, *steps: Step) -> None:
        """To the ladder of these `steps`."""
        self.steps = steps
        for number, step in enumerate(steps, start=1):
            self.known[self.kept[:number]] = step
        while len(self.known) > max(_REMEMBERED, len(steps)):
            del self.known[next(iter(self.known))]

    def push(self, label: str, added: str | None, state: State) -> None:
        """One step further, to `state`."""
        self.go(*self.steps, Step(label, Rung(added, state, self.climber.gain(self.state, state))))
