"""A diagnosis as a document: what `ident diagnose --json` prints."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Literal

from pydantic import Field

from ident.dynamics.effects.base import is_never
from recordings.config import Section

Verdict = Literal["adequate", "missing-effect", "unknown-structure"]
Numbers = tuple[float, ...]


class ParameterValue(Section):
    """One parameter."""

    value: float
    unit: str
    ci95: tuple[float, float] | None
    """None where the data do not tell."""
    meaning: str
    lower: float | None
    """Physical range; None where there is no limit."""
    upper: float | None

    @property
    def infinite(self) -> bool:
        """Whether it is an instant that does not come."""
        return is_never(self.value, self.unit)


class StepEntry(Section):
    """A model of the ladder."""

    added: str | None
    effects: tuple[str, ...]
    train_rms: Numbers
    """Per joint [N m]."""
    validate_rms: Numbers
    parameters: dict[str, ParameterValue]


def labels(rungs: Sequence[Sequence[str]]) -> list[str]:
    """Names of the models of a ladder, by what each has more or less than the one before.

    rungs: the effects of each. More than one may come at a time: what is true of any such machine is always there.
    """
    first, *others = rungs
    names = [f"base model with {', '.join(first)}" if first else "base model"]
    for before, effects in zip(rungs, others, strict=False):
        more, less = Counter(effects) - Counter(before), Counter(before) - Counter(effects)
        changes = [*(f"+ {name}" for name in more), *(f"− {name}" for name in less)]
        names.append(" ".join(changes) or "the same effects, refitted")
    return names


FindingStatus = Literal["supported", "asked-for", "not-supported"]
"""The latter two where nothing else was tried: what was asked for, and whether held-out rows bear it out."""


class FindingEntry(Section):
    """An effect that is there."""

    effect: str
    status: FindingStatus = "supported"
    in_model: bool = False
    """Whether the model with which the diagnosis began had it already."""
    joints: tuple[int, ...]
    """From 1."""
    confusable_with: tuple[str, ...]
    gain: float
    gain_ci95: tuple[float, float]
    why: str
    sentence: str
    looks: str
    causes: str
    remedy: str


class RejectedEntry(Section):
    """An effect that was looked for in vain."""

    effect: str
    status: Literal["not-supported", "not-tested", "not-observable", "absorbed"]
    why: str
    hopeless: bool = Field(default=False, exclude=True)
    """Whether it would explain hardly more than chance does: not worth a line of its own."""


class Remaining(Section):
    """What the last model leaves."""

    structured_share: float
    """Of the remaining mean square, 0 to 1."""
    depends_on: tuple[str, ...]
    why: str
    structured_rms: Numbers
    """Per joint [N m]."""


class LearnedCurveEntry(Section):
    """Curves in an effect file that take the place of what is not known."""

    file: str
    command: str
    """Which fits the model with them."""
    joints: tuple[int, ...]
    """From 1."""
    over: tuple[str, ...]
    """The variables."""
    validate_rms: Numbers
    """Per joint, with the curves [N m]."""
    gain: float
    gain_ci95: tuple[float, float]


class NextMotion(Section):
    """What to record next, and why."""

    why: str
    command: str


class Document(Section):
    """All that a diagnosis says."""

    schema_version: Literal[1] = Field(1, alias="schema")
    verdict: Verdict
    sentence: str
    """The verdict in words."""
    bandwidth_hz: float
    noise_rms: Numbers
    """Per joint: the line to reach, noise with what encoder steps propagate into it [N m]."""
    torque_rms: Numbers
    joints: tuple[str, ...]
    effort_units: tuple[str, ...]
    simulated: bool
    """Whether any of the recordings is of a simulated machine."""
    held_out: str
    """On what the models were validated."""
    rungs: tuple[StepEntry, ...]
    findings: tuple[FindingEntry, ...]
    rejected: tuple[RejectedEntry, ...]
    remaining: Remaining
    next_motion: NextMotion | None
    stand_in: LearnedCurveEntry | None = None
    cautions: tuple[str, ...] = ()
    """What these recordings tell less well than their length promises."""
    recordings: tuple[str, ...] = ()

    @property
    def labels(self) -> list[str]:
        """Names of the rungs."""
        return labels([rung.effects for rung in self.rungs])

    def as_json(self) -> dict[str, Any]:
        """As it is printed."""
        document: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        return document
