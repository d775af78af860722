"""What the working process hands to the page: plain numbers and words, ready to be shown."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ident.diagnosis.document import RungEntry
from ident.identification.model import Model
from ident.residuals.windows import Window
from recordings.recording import Bools, Floats, Ints
from recordings.rig import Geometry

Small = NDArray[np.float32]
"""An hour at 500 Hz of it does not fill the memory."""


@dataclass(frozen=True, eq=False)
class RecordingView:
    """A recording before anything is fitted."""

    name: str
    quality: tuple[tuple[str, str], ...]
    """What it is and how good, as label and value."""
    warnings: tuple[str, ...]
    events: tuple[tuple[float, str, str, str], ...]
    """Time [s], level, source, message."""
    geometry: Geometry | None
    """Of a delta robot."""
    position_units: tuple[str, ...]
    time: Floats
    """(n,) [s]."""
    signals: dict[str, tuple[str, Small]]
    """By name: unit, and (n, dof)."""


@dataclass(frozen=True, eq=False)
class Series:
    """What a model says of one recording, at the rate of the analysis: m instants of dof joints."""

    name: str
    held_out: bool
    time: Floats
    measured: Floats
    computed: Floats
    velocity: Floats
    position: Floats
    phase: NDArray[np.str_]
    """(m, dof) what each joint does."""
    cycle: Ints
    """(m,) repetition of the motion, from 1; 0 outside of all."""
    counted: Bools
    """(m, dof) which rows are judged."""

    @property
    def residual(self) -> Floats:
        """(m, dof) measured minus computed; NaN where a row does not count."""
        left: Floats = np.where(self.counted, self.measured - self.computed, np.nan)
        return left


@dataclass(frozen=True)
class Candidate:
    """An effect that could be added."""

    name: str
    joints: tuple[int, ...]
    """From 1; empty for the whole robot."""
    gain: float
    """Share of the squared error that it would take away at first sight, 0 to 1."""


@dataclass(frozen=True, eq=False)
class Signatures:
    """What each candidate would take away of the residual, in the order of `Series`."""

    removed: dict[str, tuple[Small, ...]]
    """By name: (m, dof) of each recording; NaN where it is not known."""
    figures: dict[str, dict[str, Any]]
    """By name: the same over what the effect depends on, above the residual, as a figure for Plotly."""


@dataclass(frozen=True)
class Chosen:
    """What the swarm is to fit, and how."""

    effects: tuple[str, ...] = ()
    """As `ident fit --with` takes them."""
    cutoff: float | None = None
    """[Hz]; None: chosen from the spectra."""
    seed: int = 0


@dataclass(frozen=True)
class Descent:
    """A swarm on its way to the minimum of (33)."""

    excess: tuple[float, ...]
    """Of the objective above its certified minimum, relative, after each step."""
    total: int
    """Steps that it may take."""
    goal: float
    """The excess at which it stops."""


@dataclass(frozen=True, eq=False)
class Swarmed:
    """What the swarm found."""

    model: Model
    descent: Descent
    sentences: tuple[str, ...]
    """Where the model fails."""
    command: str
    """That does the same in a terminal."""


Kept = tuple[str, tuple[tuple[str, tuple[int, ...]], ...], tuple[float, ...]]
"""A rung by its label, its effects with their joints from 1, and all its parameters."""


@dataclass(frozen=True)
class Place:
    """Where a task begins: recordings, and a ladder, which any process can climb again."""

    train: Path
    validate: Path | None
    rungs: tuple[Kept, ...]


@dataclass(frozen=True)
class RungView:
    """One model of the ladder."""

    label: str
    """What was done to the one before."""
    entry: RungEntry
    terms: tuple[tuple[str, tuple[int, ...]], ...]
    """Effects, with their joints from 1."""
    x: tuple[float, ...]
    """All parameters, from which the model can be made again."""
    gain: float | None
    """Share of the held-out error above the noise that the last change took away."""
    gain_ci95: tuple[float, float] | None

    @property
    def kept(self) -> Kept:
        """What it can be made again from."""
        return self.label, self.terms, self.x


@dataclass(frozen=True)
class LadderView:
    """The models so far, the last one being the present one."""

    train: str
    validate: str | None
    """Names of the recordings."""
    rungs: tuple[RungView, ...]
    noise_rms: tuple[float, ...]
    """Per joint: the line to reach."""
    torque_rms: tuple[float, ...]
    joints: tuple[str, ...]
    units: tuple[str, ...]
    position_units: tuple[str, ...]
    relative: bool
    """True where the torque gain is assumed."""
    simulated: bool
    bandwidth: float
    """[Hz]"""
    held_out: str
    """On what the models are validated."""
    excerpt: float | None
    """Share of the recordings that is looked at, where they are too long for all."""
    always: tuple[str, ...]
    """Effects that are true of any such machine."""
    diagnosed: bool
    """Whether the present model is the one that the full diagnosis ended with."""


@dataclass(frozen=True)
class Mismatch:
    """Two recordings that do not go together."""

    why: str


@dataclass(frozen=True)
class Choice:
    """What could be added to the present model."""

    candidates: tuple[Candidate, ...]
    """The most promising first."""
    unseen: tuple[str, ...]
    """Effects that this motion does not show."""
    unobservable: dict[str, str]
    """Effects that such a recording cannot show, and why."""


@dataclass(frozen=True)
class Failing:
    """Where the present model fails."""

    model: Model | None
    """The present model as `ident fit` would describe it; None for long recordings, until it is asked for."""
    recordings: tuple[str, ...]
    unit: str
    """Of the efforts."""
    sentences: tuple[str, ...]
    windows: tuple[Window, ...]
    """The worst stretches."""
    figures: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Title: a figure for Plotly."""


@dataclass(frozen=True)
class Answer:
    """What the full diagnosis says."""

    document: dict[str, Any]
    """As `ident diagnose --json` prints it."""
    figures: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Effect: what it changed, as a figure for Plotly."""
