"""The result of a diagnosis as a user receives it: the document, and the model with all effects found."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis.diagnosis import Diagnosis, DiagnosisOptions, StatusCallback, diagnose
from ident.diagnosis.document.diagnosed_model import diagnosed_model
from ident.diagnosis.document.document import Document, FindingEntry, Verdict
from ident.diagnosis.document.verdict import to_document
from ident.dynamics.effects.base import Effect
from ident.identification.model import Model
from ident.identification.model_file import ModelFile


@dataclass(frozen=True, eq=False)
class DiagnosisResult:
    """A diagnosis of recordings."""

    document: Document
    """What `ident diagnose --json` prints."""
    diagnosis: Diagnosis
    """Models, residuals and data behind the document."""
    files: tuple[Path, ...]
    validate: tuple[Path, ...]
    options: DiagnosisOptions

    @property
    def verdict(self) -> Verdict:
        """adequate, missing-effect, unknown-structure or undetermined."""
        return self.document.verdict

    @property
    def findings(self) -> tuple[FindingEntry, ...]:
        """The effects found, in the order in which they were added."""
        return self.document.findings

    def as_json(self) -> dict[str, Any]:
        """The document as `ident diagnose --json` prints it."""
        return self.document.as_json()

    def apply(self) -> Model:
        """The last model of the document, with all effects found: the same values, intervals and errors."""
        return Model(diagnosed_model(self.diagnosis, self.document.steps[-1]), self.diagnosis.library)


def diagnosed(
    files: tuple[Path, ...],
    validate: tuple[Path, ...],
    effects: Mapping[str, Effect],
    options: DiagnosisOptions,
    progress: StatusCallback,
    model: ModelFile | None = None,
) -> DiagnosisResult:
    """Diagnose the recordings `files` with a library of `effects`, see `ident.diagnose`.

    model: whose effects are the start; None: the base model.
    """
    diagnosis = diagnose(files, validate, effects, options, progress, model)
    return DiagnosisResult(to_document(diagnosis), diagnosis, files, validate, options)
