"""The result of a fit as a file: model.json.

Deterministic: the same recordings, settings and seed give the same bytes.
"""

import json
from collections.abc import Iterator, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any, Literal, Self

from pydantic import Field, model_validator

from ident.identification.goodness_of_fit import GoodnessOfFit
from ident.identification.saved_formula import SavedFormula
from ident.uncertainty.assessment import Assessment, ParameterUncertainty
from ident.uncertainty.time_delay import Delay
from recordings.config import ConfigSection, JsonDocument, Positive, validated
from recordings.data_problems import DataProblem
from recordings.errors import BadInput
from recordings.files import replacement, sha256
from recordings.limits import json_object
from recordings.recording import Recording
from recordings.rig import Geometry, MechanismName, Torque
from recordings.urdf import Chain, Payload

SCHEMA = 2
_DELTA_JOINTS = 3


class FittedParameter(ParameterUncertainty):
    """One identified parameter and its uncertainty; friction is positive where it opposes motion."""

    name: str
    value: float
    unit: str
    lower: float
    """Lower bound of the search region."""
    upper: float
    at_bound: bool
    paper_value: float
    """Value in the form of Eq. (36), where friction has the opposite sign."""
    meaning: str = ""
    """What it is; of a base parameter the sum of physical ones."""

    def __float__(self) -> float:
        """Its value."""
        return self.value

    def __repr__(self) -> str:
        """One line: value and interval."""
        limits = ", 95 %: {:.5g} to {:.5g}".format(*self.ci95) if self.ci95 else ""
        return f"<{self.name} = {self.value:.5g} {self.unit}{limits}>"

    __str__ = __repr__


class CertifiedMinimum(ConfigSection):
    """The exact minimum of objective (33), and the estimator's distance from it."""

    minimum: float
    """Computed minimum [N m]."""
    lower_bound: float
    """Proven lower bound of the objective in the search region [N m]."""
    excess: float
    """Upper bound of the relative difference between the estimator's objective and the minimum."""


class FitMethod(ConfigSection):
    """The estimator and its result."""

    name: str
    settings: dict[str, Any]
    seed: int
    objective: float
    rows: int
    certified: CertifiedMinimum | None = None
    """None if the estimator's objective is not (33)."""
    diagnostics: dict[str, Any] = Field(default_factory=dict)
    """Further results of the estimator, such as a rank."""


class Preprocessing(ConfigSection):
    """Conversion of measured signals to rows of the regression."""

    name: str
    bandwidth: Positive
    """[Hz]"""
    rate: Positive
    """Rows per second and joint [Hz]."""
    cutoff: str | None = None
    """Reason for the bandwidth; None if the preprocessing has a fixed one."""
    delays: tuple[Delay, ...] | None = None
    """Estimated, not applied; None if the training data do not determine them."""


Limits = tuple[float, float]


class MotionRange(ConfigSection):
    """Smallest and largest value of the motion at the rows of the fit, joint by joint."""

    position: tuple[Limits, ...]
    """[rad or m]"""
    velocity: tuple[Limits, ...]
    """[rad/s or m/s]"""
    acceleration: tuple[Limits, ...]
    """[rad/s^2 or m/s^2]"""


class RecordingSource(ConfigSection):
    """Name and digest of a recording."""

    name: str
    sha256: str
    simulated: bool


class Agreement(ConfigSection):
    """Goodness of fit on some recordings, of the model and of the manufacturer's model."""

    recordings: tuple[RecordingSource, ...]
    fitted: GoodnessOfFit
    nominal: GoodnessOfFit | None
    """None if there is no manufacturer's model."""


class EffectTerm(ConfigSection):
    """An effect on some joints; its linear coefficients are among the model's parameters."""

    name: str
    joints: tuple[int, ...]
    """Numbered from 1."""
    shapes: dict[str, float] = Field(default_factory=dict)
    parameters: tuple[dict[str, float], ...] = ()
    """Parameters of an effect on measured signals: joint by joint, or once for an effect of the whole robot."""
    formula: SavedFormula | None = None
    """Of an effect that does not come with this software; None: its file is needed."""


FloorVerdict = Literal["within-noise", "above-noise", "unknown"]


class ResidualTest(ConfigSection):
    """Test of a model's residual against the noise floor: the one verdict that every command shows."""

    verdict: FloorVerdict
    """unknown: no motion is repeated, so that the noise floor is not known."""
    diagnosed: bool = False
    """Whether a diagnosis has searched the residual for effects, which shows smaller ones than this test alone."""
    bandwidth_hz: float
    noise_rms: tuple[float | None, ...]
    """Noise floor of each joint: differences between repetitions, and quantization [N m]; None: unknown."""
    repetition_rms: tuple[float | None, ...]
    """Of that, what differs between repetitions [N m]."""
    quantization_rms: tuple[float | None, ...]
    """Of that, what quantization leaves although the motion repeats [N m]."""
    structured_rms: tuple[float, ...]
    """What is above the noise floor [N m]."""
    structured_share: float
    """Its share of the mean square of the residual, over all joints, 0 to 1."""
    missing: int = 0
    """Samples that the recordings lack, of the joint that lacks most."""
    recordings: tuple[RecordingSource, ...]
    """The recordings that were tested."""

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return {
            "within-noise": "Within the noise: nothing structured is left above the noise floor."
            if self.diagnosed
            else "Within the noise: no structure is seen above the noise floor.",
            "above-noise": f"Above the noise: {self.structured_share:.0%} of the mean square is structured.",
            "unknown": "The noise floor is unknown, because nothing repeats: whether an effect is missing is open.",
        }[self.verdict]


class ModelFile(JsonDocument):
    """An identified model."""

    software: str = Field(default_factory=lambda: version("delta-workbench"))
    mechanism: MechanismName
    form: str | None = None
    """Alternative linear model of the mechanism (`ident/dynamics/forms/`); None: the mechanism's own model."""
    effects: tuple[str, ...] = ()
    """Names of the effects, in the order in which they were added."""
    terms: tuple[EffectTerm, ...] = ()
    """The same effects, with their joints and the values that are not among the parameters."""
    joints: tuple[str, ...]
    effort_units: tuple[str, ...] = ("N m", "N m", "N m")
    """Unit of the effort of each joint."""
    geometry: Geometry | None
    """Geometry of a delta robot; None for other mechanisms."""
    robot: Chain | None = None
    """Keys of the mechanism "urdf", with the text of the URDF; None for other mechanisms."""
    payload: Payload | None = None
    """That of the rig, which the parameters include."""
    torque: Torque
    relative: bool
    """True if the torque gain is assumed: all parameters are then known up to one common factor."""
    parameters: tuple[FittedParameter, ...]
    """In which the torque is linear."""
    searched: tuple[FittedParameter, ...] = ()
    """Shapes and other values found by a search, which `terms` hold too, for tables of all parameters."""
    method: FitMethod
    preprocessing: Preprocessing
    motion_range: MotionRange | None = None
    """Of the fit; None in a file that does not say it."""
    train: Agreement
    validate_: Agreement | None = Field(None, alias="validate")
    assessment: Assessment | None = None
    """None for alternative forms of the mechanism, which serve only for comparison."""
    residual_test: ResidualTest | None = None
    """On the training and validation data together; None for alternative forms."""
    data_problems: tuple[DataProblem, ...] = ()
    """Of the recordings, in spite of which they were used."""

    @model_validator(mode="after")
    def _check_sizes(self) -> Self:
        """Check that what stands beside each other fits together, as no schema says."""
        dof = len(self.joints)
        if not dof or (self.mechanism == "delta" and (dof != _DELTA_JOINTS or self.geometry is None)):
            raise ValueError(
                "joints: those of the mechanism expected, and the geometry of a delta robot, others found"
            )
        for name, values in self._of_joints():
            if len(values) != dof:
                raise ValueError(f"{name}: a value for each of {dof} joints expected, {len(values)} found")
        for term in self.terms:
            if (
                not term.joints
                or not set(term.joints) <= set(range(1, dof + 1))
                or len({*term.joints}) < len(term.joints)
            ):
                raise ValueError(
                    f"terms: {term.name}: different joints from 1 to {dof} expected, {term.joints} found"
                )
        if self.assessment:
            correlation, cutoffs = self.assessment.correlation, self.assessment.cutoffs
            if any(len(row) != len(correlation) for row in correlation):
                raise ValueError("assessment.correlation: as many rows as columns expected, others found")
            if any(len(each.per_cutoff) not in (0, len(cutoffs)) for each in self.parameters):
                raise ValueError(f"parameters: per_cutoff with {len(cutoffs)} values expected, others found")
        return self

    def _of_joints(self) -> Iterator[tuple[str, Sequence[Any]]]:
        """Yield what has a value for each joint, with its name."""
        yield "effort_units", self.effort_units
        yield "torque.gain", self.torque.gain
        if self.torque.per_ampere:
            yield "torque.per_ampere", self.torque.per_ampere
        for agreement in filter(None, (self.train, self.validate_)):
            for fit in filter(None, (agreement.fitted, agreement.nominal)):
                yield from vars(fit).items()
        if self.motion_range:
            yield from ((f"motion_range.{name}", limits) for name, limits in self.motion_range)
        if self.residual_test:
            names = ("noise_rms", "repetition_rms", "quantization_rms", "structured_rms")
            yield from ((f"residual_test.{name}", getattr(self.residual_test, name)) for name in names)
        if self.assessment:
            yield "assessment.noise", self.assessment.noise
            yield "assessment.floor", self.joints if self.assessment.floor is None else self.assessment.floor

    @property
    def all_parameters(self) -> tuple[FittedParameter, ...]:
        """Parameters in the order of tables: those of the mechanism, then of each effect."""
        entries = (*self.parameters, *self.searched)
        groups = ["", *dict.fromkeys(entry.name.partition(".")[0] for entry in entries if "." in entry.name)]
        of_effect = [entry.name.partition(".")[0] if "." in entry.name else "" for entry in entries]
        return tuple(
            entry for group in groups for entry, name in zip(entries, of_effect, strict=True) if name == group
        )


def recording_source(recording: Recording) -> RecordingSource:
    """Return name and digest of the file of `recording`."""
    return RecordingSource(name=recording.path.name, sha256=recording.digest, simulated=recording.run.simulated)


def find_recording(source: RecordingSource, model_path: Path) -> Path | None:
    """The file of a recording of the model in `model_path`, if it lies beside the model or here, unchanged."""
    files = (folder / source.name for folder in (model_path.parent, Path()))
    return next((file for file in files if file.is_file() and sha256(file) == source.sha256), None)


def text(model: ModelFile) -> str:
    """Content of the file of `model`."""
    return json.dumps(model.as_json(), indent=2, allow_nan=False) + "\n"


def save(model: ModelFile, path: Path) -> None:
    """Write `model` to `path`, replacing it in one step."""
    with replacement(path) as partial:
        partial.write_text(text(model), encoding="utf-8")


def load(path: Path) -> ModelFile:
    """Read a model file.

    Raises:
        BadInput: the file is missing, is not JSON, has another schema or an unknown mechanism, is incomplete, or
            names other effects than it holds.
    """
    content = json_object(path, "model file")
    if not isinstance(content.get("schema"), int):
        raise BadInput(f"model file {path}: a key 'schema' with an integer expected, none found; is it a model?")
    if content["schema"] != SCHEMA:
        advice = "update this software" if content["schema"] > SCHEMA else "fit the recordings again"
        raise BadInput(f"model file {path}: schema {SCHEMA} expected, {content['schema']} found; {advice}")
    model = validated(content, ModelFile, f"model file {path}")
    terms = tuple(term.name for term in model.terms)
    if model.effects != terms:
        raise BadInput(
            f"model file {path}: effects [{', '.join(terms)}] expected, those of its terms, "
            f"[{', '.join(model.effects)}] found; take the file as `ident` wrote it, or fit again"
        )
    return model
