"""Everything that a report is made from: models, recordings, what compare and diagnose say of them."""

import hashlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis import answer
from ident.diagnosis.diagnosis import DiagnosisOptions, Diagnosis, diagnose
from ident.diagnosis.document import Document
from ident.dynamics.effects.library import library
from ident.identification import model, prediction
from ident.identification.model import Model, Source
from ident.residuals import analysis
from ident.residuals.analysis import Comparison
from recordings.recording import Recording

SCHEMA = 1


@dataclass(frozen=True)
class ReportRequest:
    """What the user asked for."""

    models: tuple[Path, ...]
    recordings: tuple[Path, ...]
    held_out: tuple[Path, ...]
    effect_files: tuple[Path, ...]
    diagnose: bool


@dataclass(frozen=True, eq=False)
class ReportContents:
    """What the report shows; models and recordings by the names they have in it."""

    request: ReportRequest
    models: Mapping[str, Model]
    digests: Mapping[str, str]
    """SHA-256 of the model files."""
    comparisons: Mapping[str, Comparison]
    held_out_comparisons: Mapping[str, Comparison]
    """Empty where no recording was held out."""
    sources: tuple[Source, ...]
    """The recordings, those held out last."""
    diagnosis: Diagnosis | None
    document: Document | None
    """What the diagnosis says."""

    @property
    def primary_comparisons(self) -> Mapping[str, Comparison]:
        """What the models are judged on: the recordings held out, if there are any."""
        return self.held_out_comparisons or self.comparisons

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """Those held out last."""
        return tuple(prediction.dataset.recording for _, _, prediction in self.predictions)

    @property
    def predictions(self) -> tuple[tuple[Mapping[str, Comparison], int, prediction.Prediction], ...]:
        """Of each recording: the comparisons it is in, its place there, and what the first model makes of it."""
        groups = [self.comparisons, *([self.held_out_comparisons] if self.held_out_comparisons else [])]
        return tuple(
            (group, place, found)
            for group in groups
            for place, found in enumerate(next(iter(group.values())).predictions)
        )

    def as_json(self) -> dict[str, Any]:
        """The numbers, as `ident compare --json` and `ident diagnose --json` print them."""
        groups = [(False, self.comparisons), (True, self.held_out_comparisons)]
        return {
            "schema": SCHEMA,
            "models": [{"name": name, "sha256": digest} for name, digest in self.digests.items()],
            "recordings": [source.model_dump(mode="json") for source in self.sources],
            "comparisons": [
                {"model": name, "held_out": held, "comparison": analysis.as_json(found)}
                for held, group in groups
                for name, found in group.items()
            ],
            "diagnosis": self.document.as_json() if self.document else None,
        }


def gather(request: ReportRequest, progress: Callable[[str], None]) -> ReportContents:
    """Compare every model with every recording, and find out what the base model lacks, if that is asked for.

    Raises:
        BadInput: a file cannot be used, or they are not of the same rig.
    """
    known = library(request.effect_files)
    paths = dict(zip(_names(request.models), request.models, strict=True))
    models = {name: model.load(path) for name, path in paths.items()}

    def compared(files: Sequence[Path]) -> dict[str, Comparison]:
        found = {}
        for name, one in models.items():
            progress(f"comparing {name}")
            found[name] = analysis.compare(one, prediction.predict(one, files, known))
        return found

    recorded = compared(request.recordings)
    held_out = compared(request.held_out) if request.held_out else {}
    diagnosis = None
    if request.diagnose:
        diagnosis = diagnose(request.recordings, request.held_out, known, DiagnosisOptions(), progress)
    groups = [recorded, *([held_out] if held_out else [])]
    read = [one.dataset.recording for group in groups for one in next(iter(group.values())).predictions]
    return ReportContents(
        request=request,
        models=models,
        digests={name: _digest(path) for name, path in paths.items()},
        comparisons=recorded,
        held_out_comparisons=held_out,
        sources=tuple(model.source(recording) for recording in read),
        diagnosis=diagnosis,
        document=answer.to_document(diagnosis) if diagnosis else None,
    )


def _names(paths: Sequence[Path]) -> list[str]:
    """Of the files, with their folders where that alone tells them apart."""
    names = [path.name for path in paths]
    return [str(path) if names.count(path.name) > 1 else path.name for path in paths]


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
