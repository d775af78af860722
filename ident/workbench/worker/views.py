"""Data that the worker sends to the page: numbers, texts and figures ready to be shown."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis.document.document import StepEntry
from ident.diagnosis.judge.improvement import Improvement
from ident.identification.model_file import ModelFile
from ident.output.tables import ResultTable
from ident.residuals.phases import Window
from ident.residuals.time_span import Float32s, TorqueSeries
from recordings.data_problems import DataProblem
from recordings.recording import Floats
from recordings.rig import Geometry


@dataclass(frozen=True, eq=False)
class RecordingView:
    """A recording before any fit."""

    name: str
    quality: dict[str, str]
    """Metadata and quality by label."""
    warnings: tuple[str, ...]
    problems: tuple[DataProblem, ...]
    """What cannot be right about it."""
    events: tuple[tuple[float, str, str, str], ...]
    """Time [s], level, source, message."""
    geometry: Geometry | None
    """None unless the mechanism is a delta robot."""
    time: Floats
    """(n,) [s]."""
    signals: dict[str, tuple[str, Float32s]]
    """By name: unit, and (n, dof)."""
    columns: tuple[str, ...] = ()
    """Names for `daq import`, such as position_1."""


@dataclass(frozen=True)
class CandidateCard:
    """An effect that can be added to the current model."""

    name: str
    joints: tuple[int, ...]
    """Numbers from 1; empty for the whole robot."""
    improvement: float
    """Estimated share of the squared error that it would remove, 0 to 1."""


@dataclass(frozen=True, eq=False)
class CandidatePreviews:
    """Part of the residual that each candidate would explain, for each series in order."""

    contributions: dict[str, tuple[Float32s, ...]]
    """By name: (m, dof) of each recording; NaN where unknown."""
    figures: dict[str, dict[str, Any]]
    """By name: Plotly figure of residual and contribution over the variable of the effect."""


@dataclass(frozen=True)
class StepView:
    """One model of the list of steps."""

    label: str
    """Change from the model before."""
    entry: StepEntry
    terms: tuple[tuple[str, tuple[int, ...]], ...]
    """Effects, with their joints from 1."""
    x: tuple[float, ...]
    """All parameters, from which the model can be rebuilt."""
    improvement: Improvement | None
    """By the last change, on the held-out rows; None for the first model."""
    refusal: str
    """Why the judge does not accept the effect that was added last; empty if it does, or none was added."""


@dataclass(frozen=True)
class StepsSpec:
    """Start of a task: recordings, and the steps to a model, which any process can fit again from its parameters."""

    train: Path
    validate: Path | None
    steps: tuple[StepView, ...]
    diagnosed: bool = False
    """Whether the full diagnosis has found the last model."""


@dataclass(frozen=True)
class Findings:
    """What the full diagnosis says."""

    document: dict[str, Any]
    """Document of `ident diagnose --json`."""
    law: str | None
    """Effect file with the formula in the document, if there is one."""


@dataclass(frozen=True, eq=False)
class StepsView:
    """The models so far; the last one is the current one."""

    train: str
    validate: str | None
    """Names of the recordings."""
    digests: tuple[str, ...]
    """SHA-256 of these files."""
    steps: tuple[StepView, ...]
    noise_rms: tuple[float | None, ...]
    """Noise floor of each joint; None if nothing repeats."""
    units: tuple[str, ...]
    """Units of the efforts."""
    position_units: tuple[str, ...]
    relative: bool
    """True where the torque gain is assumed."""
    simulated: bool
    bandwidth: float
    """[Hz]"""
    held_out: str
    """Description of the validation data."""
    excerpt: float | None
    """Share of the recordings that is analysed where they are too long; None for all."""
    mandatory: tuple[str, ...]
    """Names of the mandatory effects."""
    findings: Findings | None
    """What the full diagnosis has said, whose final model is the current one."""
    warnings: tuple[str, ...] = ()
    """What limits the errors of the steps."""

    @property
    def added(self) -> tuple[tuple[str, tuple[int, ...]], ...]:
        """Return the effects of the current model beyond the mandatory ones, with their joints."""
        return tuple((name, joints) for name, joints in self.steps[-1].terms if name not in self.mandatory)


@dataclass(frozen=True)
class Mismatch:
    """Two recordings that cannot be used together."""

    reason: str


@dataclass(frozen=True)
class CandidateList:
    """Effects that can be added to the current model."""

    cards: tuple[CandidateCard, ...]
    """In descending order of improvement."""
    not_excited: tuple[str, ...]
    """Effects that this motion does not excite, or only with an inadmissible sign."""
    unobservable: dict[str, str]
    """Effects that such a recording cannot show, with the reason."""


@dataclass(frozen=True)
class Advice:
    """Whether to add an effect next; the last view of a model."""

    effect: str | None
    """None where no effect explains enough."""
    improvement: float = 0.0
    """As that of its card."""
    refusal: str = ""
    """Why the judge does not accept it; empty if it does."""


@dataclass(frozen=True)
class ResidualView:
    """Residual analysis of the current model."""

    model: ModelFile
    """The current model as it is saved."""
    recordings: tuple[str, ...]
    sentences: tuple[str, ...]
    windows: tuple[Window, ...]
    """Intervals with the largest residuals."""
    window_table: ResultTable
    figures: dict[str, dict[str, Any]]
    """Plotly figures by title."""
    causes: ResultTable
    """The torque of the current model by its causes, in the first of the recordings."""
    causes_sentences: tuple[str, ...]
    causes_figure: dict[str, Any]
    """Plotly figure."""


@dataclass(frozen=True, eq=False)
class FindingFigures:
    """Figures of the findings of the full diagnosis."""

    figures: dict[str, dict[str, Any]]
    """By effect: Plotly figure of the residual before and after."""


View = (
    RecordingView
    | Mismatch
    | StepsView
    | tuple[TorqueSeries, ...]
    | CandidateList
    | CandidatePreviews
    | ResidualView
    | Advice
    | FindingFigures
)
"""What the worker sends to the page."""
