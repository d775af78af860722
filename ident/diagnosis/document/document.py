"""The JSON document of a diagnosis, as printed by `ident diagnose --json`."""

from collections import Counter
from collections.abc import Sequence
from typing import Any, Literal

from pydantic import Field

from ident.dynamics.effects.base import is_infinite
from recordings.config import ConfigSection

Verdict = Literal["adequate", "missing-effect", "unknown-structure", "undetermined"]
NoiseSource = Literal["repetition", "unknown"]
Numbers = tuple[float, ...]
UNKNOWN_FLOOR = "unknown (nothing repeats)"
"""In place of the noise floor, where it is not known."""


class ParameterValue(ConfigSection):
    """One parameter."""

    value: float
    unit: str
    ci95: tuple[float, float] | None
    """None if the parameter is not identifiable; with the gain's uncertainty if the parameters are absolute."""
    shape_ci95: tuple[float, float] | None = None
    """The same for an exactly known gain, whose error all torques share; None: equal to `ci95`."""
    meaning: str
    lower: float | None
    """Physical limits; None: unbounded."""
    upper: float | None

    @property
    def interval(self) -> tuple[float, float] | None:
        """The interval that tables show: for an exactly known gain."""
        return self.shape_ci95 or self.ci95

    @property
    def infinite(self) -> bool:
        """Whether it is an instant that never occurs."""
        return is_infinite(self.value, self.unit)


class StepEntry(ConfigSection):
    """One model of the selection."""

    added: str | None
    effects: tuple[str, ...]
    train_rms: Numbers
    """Per joint [N m]."""
    validate_rms: Numbers
    train_rms_all: Numbers = ()
    """On all rows, with those that are not scored: near standstill, or near the limit of the amplifiers."""
    validate_rms_all: Numbers = ()
    parameters: dict[str, ParameterValue]


def labels(models: Sequence[Sequence[str]]) -> list[str]:
    """Names of the models of a selection, by the difference of their effects from the model before.

    models: the effects of each model. A step may add several effects: mandatory effects are always included.
    """
    first, *others = models
    names = [f"base model with {', '.join(first)}" if first else "base model"]
    for before, effects in zip(models, others, strict=False):
        added, removed = Counter(effects) - Counter(before), Counter(before) - Counter(effects)
        changes = [*(f"+ {name}" for name in added), *(f"− {name}" for name in removed)]
        names.append(" ".join(changes) or "the same effects, refitted")
    return names


FindingStatus = Literal["supported", "asked-for", "not-supported"]
"""The latter two apply to forced effects: requested and supported by the test rows, or requested and not supported.
"""


class FindingEntry(ConfigSection):
    """An effect that was found."""

    effect: str
    status: FindingStatus = "supported"
    in_model: bool = False
    """Whether the initial model already contained it."""
    joints: tuple[int, ...]
    """From 1."""
    confusable_with: tuple[str, ...]
    gain: float
    gain_ci95: tuple[float, float]
    share: float | None = None
    """Its part of the held-out error above the noise floor of the first model: the parts of all findings add up to
    the fall to the last model. None if the first model has it, or above the low-pass."""
    why: str
    sentence: str
    looks: str
    causes: str
    remedy: str


class RejectedEntry(ConfigSection):
    """An effect that was tested but not found, or could not be tested."""

    effect: str
    status: Literal["refuted", "not-confirmed", "not-tested", "not-observable", "absorbed"]
    why: str
    hopeless: bool = Field(default=False, exclude=True)
    """Whether it would explain hardly more than chance: it needs no line of its own."""


class Remaining(ConfigSection):
    """The residual of the final model."""

    structured_share: float
    """Of the mean square of the residual, 0 to 1."""
    depends_on: tuple[str, ...]
    why: str
    structured_rms: Numbers
    """Per joint [N m]."""


class VibrationEntry(ConfigSection):
    """A wave over time above the low-pass: a vibration, or an electrical line as of the mains."""

    joint: int
    """From 1."""
    frequency_hz: float
    amplitude: float
    """[N m]"""


class AboveLowPass(ConfigSection):
    """What lies above the low-pass of the analysis."""

    low_hz: float
    high_hz: float
    unexplained_share: Numbers
    """Per joint: RMS that nothing explains, relative to that of the measured torque."""
    vibrations: tuple[VibrationEntry, ...]
    why: str


class LearnedCurveEntry(ConfigSection):
    """Learned curves in an effect file that replace an unknown effect."""

    file: str
    command: str
    """Command that fits the model with the curves."""
    joints: tuple[int, ...]
    """From 1."""
    over: tuple[str, ...]
    """The variables of the curves."""
    validate_rms: Numbers
    """Per joint, with the curves [N m]."""
    gain: float
    gain_ci95: tuple[float, float]


class NextMotion(ConfigSection):
    """The motion to record next, and why."""

    why: str
    command: str


class Document(ConfigSection):
    """The complete result of a diagnosis."""

    schema_version: Literal[1] = Field(1, alias="schema")
    verdict: Verdict
    sentence: str
    """The verdict in words."""
    bandwidth_hz: float
    """Highest frequency in the errors: the low-pass of the analysis, or above the highest ripple that was found."""
    noise_rms: tuple[float | None, ...]
    """Per joint: noise floor, including the propagated encoder quantization [N m]; None if nothing repeats."""
    noise_source: NoiseSource = "repetition"
    """From what the noise floor is known."""
    torque_rms: Numbers
    joints: tuple[str, ...]
    effort_units: tuple[str, ...]
    relative: bool = False
    """Whether the torque gain is assumed: the parameters are then known up to one common factor."""
    scale_uncertainty: float = 0.0
    """Relative standard uncertainty of that factor, the torque gain; 0 for measured torque."""
    simulated: bool
    """Whether any of the recordings is of a simulated machine."""
    held_out: str
    """The data on which the models were validated."""
    rungs: tuple[StepEntry, ...]
    findings: tuple[FindingEntry, ...]
    rejected: tuple[RejectedEntry, ...]
    remaining: Remaining
    next_motion: NextMotion | None
    above_low_pass: AboveLowPass | None = None
    """None if the preprocessing keeps no samples at full rate."""
    stand_in: LearnedCurveEntry | None = None
    cautions: tuple[str, ...] = ()
    """Limitations of these recordings that affect the results."""
    recordings: tuple[str, ...] = ()

    @property
    def labels(self) -> list[str]:
        """Names of the models in `rungs`."""
        return labels([step.effects for step in self.rungs])

    def as_json(self) -> dict[str, Any]:
        """The document as it is printed."""
        document: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        return document
