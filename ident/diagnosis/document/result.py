"""The result of a diagnosis as a user receives it: the document, and the model with all effects found."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis.diagnosis import Diagnosis, DiagnosisOptions, StatusCallback, diagnose
from ident.diagnosis.document.diagnosed_model import model_file, with_errors
from ident.diagnosis.document.document import Document, FindingEntry, Verdict
from ident.diagnosis.document.ripple_model import with_ripple_terms
from ident.diagnosis.document.verdict import to_document
from ident.dynamics.effects.library import library
from ident.identification.model import Model


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
        file = model_file(self.diagnosis.model, self.diagnosis.unexplained)
        last = self.document.steps[-1]
        file = with_errors(file, last.train_rms, last.held_out_rms)
        return Model(with_ripple_terms(file, self.diagnosis.ripple), self.diagnosis.library)


def diagnosed(
    files: Sequence[Path],
    validate: Sequence[Path],
    effect_files: Sequence[Path],
    options: DiagnosisOptions,
    progress: StatusCallback,
    model: Model | None,
) -> DiagnosisResult:
    """Diagnose the recordings `files`, see `ident.diagnose`."""
    # A file of the user is executed once: what the model was loaded with is there already.
    effects = model.library if model and not effect_files else library(effect_files)
    diagnosis = diagnose(files, validate, effects, options, progress, model.file if model else None)
    return DiagnosisResult(to_document(diagnosis), diagnosis, tuple(files), tuple(validate), options)
