"""The result of a fit as a file: model.json.

Deterministic: the same recordings, settings and seed give the same bytes.
"""

import hashlib
import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal

from pydantic import Field

from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.uncertainty.assessment import ParameterUncertainty, Assessment
from recordings.config import Section, validated
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Geometry, Mechanism, Torque

SCHEMA = 1


class FittedParameter(ParameterUncertainty):
    """One identified parameter and how well it is known; friction is positive where it opposes motion."""

    name: str
    value: float
    unit: str
    lower: float
    """Search region."""
    upper: float
    at_bound: bool
    paper_value: float
    """In the form of (36), where friction has the opposite sign."""


class CertifiedMinimum(Section):
    """The exact minimum of objective (33), and how near the estimator came."""

    minimum: float
    """[N m], as it was computed."""
    lower_bound: float
    """[N m], proven: no parameters in the search region have a lower objective."""
    excess: float
    """How far at most the estimator's objective is above the minimum, relative."""


class FitMethod(Section):
    """The estimator and what it ended with."""

    name: str
    settings: dict[str, Any]
    seed: int
    objective: float
    rows: int
    certified: CertifiedMinimum | None = None
    """Only where the estimator's objective is (33)."""
    diagnostics: dict[str, Any] = Field(default_factory=dict)
    """What else the estimator has to say, such as a rank."""


class JointDelay(Section):
    """How far torque and motion of one joint are apart; positive where the torque follows the voltage."""

    seconds: float
    half_width: float
    """Of the 95 % interval [s]."""


class Preprocessing(Section):
    """How measured signals became rows."""

    name: str
    bandwidth: float
    """[Hz]"""
    rate: float
    """Rows per second and joint [Hz]."""
    cutoff: str | None = None
    """Why this bandwidth, in words; None where the preprocessing has no choice."""
    delays: tuple[JointDelay, ...] | None = None
    """Estimated, not applied; None where the training data do not tell."""


class RecordingSource(Section):
    """A recording that was used."""

    name: str
    sha256: str
    simulated: bool


class JointGoodnessOfFit(Section):
    """Agreement with the measured torque, one number per joint."""

    nrmse: tuple[float, ...]
    """Eq. (41)."""
    rms: tuple[float, ...]
    """[N m]"""
    r2: tuple[float, ...]

    @classmethod
    def of(cls, fitness: GoodnessOfFit) -> "JointGoodnessOfFit":
        """The same numbers, ready for a file."""
        return cls(nrmse=fitness.nrmse, rms=fitness.rms, r2=fitness.r2)


class Agreement(Section):
    """The model on some recordings, and the manufacturer's model on the same."""

    recordings: tuple[RecordingSource, ...]
    fitted: JointGoodnessOfFit
    nominal: JointGoodnessOfFit | None
    """None where the manufacturer has no model."""


class EffectTerm(Section):
    """An effect on some joints. Coefficients in which the torque is linear are among the model's parameters."""

    name: str
    joints: tuple[int, ...]
    """From 1."""
    shapes: dict[str, float] = Field(default_factory=dict)
    parameters: tuple[dict[str, float], ...] = ()
    """Of an effect on what was measured: joint by joint, or once if it is one of the whole robot."""


class Model(Section):
    """An identified model."""

    schema_version: Literal[1] = Field(1, alias="schema")
    software: str = Field(default_factory=lambda: version("delta-workbench"))
    mechanism: Mechanism
    form: str | None = None
    """Linear model of the mechanism that was identified (`ident/dynamics/forms/`); None: the mechanism's own."""
    effects: tuple[str, ...] = ()
    """What was added to the mechanism, in this order."""
    terms: tuple[EffectTerm, ...] = ()
    """The same, with where each is and with all that is not among the parameters."""
    joints: tuple[str, ...]
    effort_units: tuple[str, ...] = ("N m", "N m", "N m")
    """Of each joint."""
    geometry: Geometry | None
    """Of a delta robot."""
    torque: Torque
    relative: bool
    """True where the torque gain is assumed: all parameters are then known up to one common factor."""
    parameters: tuple[FittedParameter, ...]
    method: FitMethod
    preprocessing: Preprocessing
    train: Agreement
    validate_: Agreement | None = Field(None, alias="validate")
    trust: Assessment | None = None
    """None for forms of the mechanism that are not meant to be true, but to be compared with."""

    def as_json(self) -> Mapping[str, Any]:
        """As it stands in the file."""
        document: dict[str, Any] = self.model_dump(mode="json", by_alias=True)
        return document


def recording_source(recording: Recording) -> RecordingSource:
    """Name and digest of a recording's file."""
    with recording.path.open("rb") as file:
        digest = hashlib.file_digest(file, "sha256").hexdigest()
    return RecordingSource(name=recording.path.name, sha256=digest, simulated=recording.run.simulated)


def save(model: Model, path: Path) -> None:
    """Write `model` to `path`, replacing it in one step."""
    partial = path.with_name(path.name + ".part")
    try:
        partial.write_text(json.dumps(model.as_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def load(path: Path) -> Model:
    """Read a model file.

    Raises:
        BadInput: the file is missing, is not JSON, is of a newer schema, of an unknown mechanism, or incomplete.
    """
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:
        raise BadInput(f"model file {path} does not exist; check the path") from None
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise BadInput(f"model file {path}: JSON written by `ident fit` expected, {error}") from None
    if not isinstance(content, dict) or not isinstance(content.get("schema"), int):
        raise BadInput(f"model file {path}: a key 'schema' with a whole number expected, none found; is it a model?")
    if content["schema"] > SCHEMA:
        raise BadInput(
            f"model file {path}: schema up to {SCHEMA} expected, {content['schema']} found; update this software"
        )
    return validated(content, Model, f"model file {path}")
