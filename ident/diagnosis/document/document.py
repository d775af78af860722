"""The JSON document of a diagnosis, as printed by `ident diagnose --json`."""

import math
from collections import Counter
from collections.abc import Sequence
from typing import Any, Literal

from ident.diagnosis.judge.judge import Evidence, RejectionStatus
from ident.diagnosis.split.noise_floor import NoiseSource
from ident.dynamics.effects.base import is_infinite
from ident.dynamics.structure import Term
from recordings.config import ConfigSection, JsonDocument
from recordings.data_problems import DataProblem

Verdict = Literal["adequate", "missing-effect", "unknown-structure", "undetermined"]
Numbers = tuple[float, ...]


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

    @property
    def in_words(self) -> str:
        """Value, interval and unit."""
        if self.infinite:
            return "never"
        low, high = self.interval or (self.value, self.value)
        if high <= low:
            return f"{self.value:.4g} {self.unit}"
        # Of a narrow interval, such as that of an order of ripple, two digits have to differ.
        digits = max(4, 2 + math.ceil(math.log10(max(abs(low), abs(high)) / (high - low))))
        return f"{self.value:.{digits}g} ({low:.{digits}g} to {high:.{digits}g}) {self.unit}"


class StepEntry(ConfigSection):
    """One model of the selection."""

    added: str | None
    effects: tuple[str, ...]
    train_rms: Numbers
    """Per joint [N m]."""
    held_out_rms: Numbers
    train_rms_all: Numbers = ()
    """On all rows, with those that are not scored: near standstill, or near the limit of the amplifiers."""
    held_out_rms_all: Numbers = ()
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


def joint_numbers(joints: Sequence[int]) -> str:
    """The `joints` (from 1) in words."""
    return f"joint{'s' if len(joints) > 1 else ''} {', '.join(map(str, joints))}"


def share_in_words(share: float, interval: tuple[float, float]) -> str:
    """A `share` with its 95 % `interval`, where its digits differ; in words where that says nothing."""
    shown, low, high = (f"{round(100 * value)}%" for value in (share, *interval))
    if interval[0] <= -1 and interval[1] >= 1:
        return f"{shown} (these rows do not tell how much more or less)"
    return shown if low == high == shown else f"{shown} ({low} to {high})"


class FindingEntry(ConfigSection):
    """An effect that was found, or is likely."""

    effect: str
    status: Literal["supported", "likely", "asked-for", "not-supported"] = "supported"
    """The latter two apply to forced effects: requested and supported by the held-out rows, or not."""
    in_model: bool = False
    """Whether the initial model already contained it."""
    joints: tuple[int, ...]
    """From 1."""
    confusable_with: tuple[str, ...] = ()
    evidence: Evidence
    share: float | None = None
    """Its part of the held-out mean square above the noise floor that the first model leaves, over all joints: the
    parts of all findings add up to the fall to the last model. None if the first model has it, or above the
    low-pass."""
    why: str
    sentence: str
    symptom: str
    causes: str
    remedy: str

    @classmethod
    def of(cls, term: Term, evidence: Evidence, why: str, **fields: Any) -> "FindingEntry":
        """The entry of a `term` with what the library says of its effect; `fields`: how it was found."""
        effect = term.effect
        return cls(
            effect=term.name,
            joints=tuple(joint + 1 for joint in term.joints),
            evidence=evidence,
            why=why,
            sentence=effect.sentence,
            symptom=effect.symptom,
            causes=effect.causes,
            remedy=effect.remedy,
            **fields,
        )


class RejectedEntry(ConfigSection):
    """An effect that was tested but not found, or could not be tested."""

    effect: str
    status: RejectionStatus
    evidence: Evidence | None = None
    """Beside the last model; None where it was not tested."""
    why: str


class FormulaEntry(ConfigSection):
    """A formula for what no effect explains, which held-out rows confirm."""

    joints: tuple[int, ...]
    """From 1."""
    text: str
    """In the quantities of each of these joints, or of the joint whose number follows."""
    parameters: dict[str, ParameterValue]
    """The number behind a coefficient is that of its joint."""
    held_out_rms: Numbers
    """Of the model with the formula, per joint [N m]."""
    explains: float
    """Share of the held-out mean square above the noise floor that the model without it leaves."""
    alternatives: tuple[str, ...]
    """Other formulas that these data cannot tell from it, the simplest first."""
    resembles: str | None
    """The effect of the library that explains most of the same; None if none explains anything."""
    known_for: str
    """The motion from which it is known; beyond it, it is an extrapolation."""


class Remaining(ConfigSection):
    """The residual of the final model."""

    structured_share: float
    """Of the mean square of the residual, 0 to 1."""
    depends_on: tuple[str, ...]
    why: str
    structured_rms: Numbers
    """Per joint [N m]."""
    formula: FormulaEntry | None = None
    """Only where one was asked for."""


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
    held_out_rms: Numbers
    """Per joint, with the curves [N m]."""
    gain: float
    gain_ci95: tuple[float, float]


class NextMotion(ConfigSection):
    """The motion to record next, and why."""

    why: str
    command: str


class Document(JsonDocument):
    """The complete result of a diagnosis."""

    verdict: Verdict
    sentence: str
    """What a person would say first: what is missing, how large it is, and what it takes of the error."""
    bandwidth_hz: float
    """Highest frequency in the errors: the low-pass of the analysis, or above the highest ripple that was found."""
    data_problems: tuple[DataProblem, ...] = ()
    noise_rms: Numbers
    """Per joint: noise floor, including the propagated encoder quantization [N m]."""
    noise_ci95: tuple[tuple[float, float], ...]
    noise_source: NoiseSource
    """From what the noise floor is known."""
    torque_rms: Numbers
    explained_share: Numbers
    """Per joint: 1 - held-out mean square of the last step over that of the torque."""
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
    steps: tuple[StepEntry, ...]
    findings: tuple[FindingEntry, ...]
    likely: tuple[FindingEntry, ...] = ()
    """Effects for which the evidence speaks, but which these held-out rows lack the power to confirm."""
    rejected: tuple[RejectedEntry, ...]
    remaining: Remaining
    next_motion: NextMotion | None
    above_low_pass: AboveLowPass | None = None
    """None if the preprocessing keeps no samples at full rate."""
    learned_curve: LearnedCurveEntry | None = None
    warnings: tuple[str, ...] = ()
    """Limitations of these recordings that affect the results."""
    recordings: tuple[str, ...] = ()

    @property
    def error_lines(self) -> list[str]:
        """The held-out error of each joint, from the first model to the last."""
        errors = zip(self.steps[0].held_out_rms, self.steps[-1].held_out_rms, strict=True)
        named = zip(self.joints, self.effort_units, errors, strict=True)
        return [f"{joint}  {before:.3g} → {after:.3g} {unit}" for joint, unit, (before, after) in named]

    @property
    def labels(self) -> list[str]:
        """Names of the models in `steps`."""
        return labels([step.effects for step in self.steps])
