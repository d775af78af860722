"""Contents of a report: models, recordings, residual analyses and diagnosis."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis import verdict
from ident.diagnosis.diagnosis import Diagnosis, DiagnosisOptions, diagnose
from ident.diagnosis.document import Document
from ident.dynamics.effects.library import library
from ident.identification import model_file, prediction
from ident.identification.model_file import ModelFile, RecordingSource
from ident.residuals import analysis
from ident.residuals.analysis import ResidualAnalysis
from recordings.digest import sha256
from recordings.recording import Recording

SCHEMA = 1


@dataclass(frozen=True)
class ReportRequest:
    """Files and options of the command."""

    models: tuple[Path, ...]
    recordings: tuple[Path, ...]
    held_out: tuple[Path, ...]
    effect_files: tuple[Path, ...]
    diagnose: bool


@dataclass(frozen=True, eq=False)
class ReportContents:
    """Data that the report shows; models by the names they have in it."""

    request: ReportRequest
    models: Mapping[str, ModelFile]
    digests: Mapping[str, str]
    """SHA-256 of the model files."""
    analyses: Mapping[str, ResidualAnalysis]
    """By model, on the recordings given."""
    held_out_analyses: Mapping[str, ResidualAnalysis]
    """By model, on the recordings held out; empty if there are none."""
    sources: tuple[RecordingSource, ...]
    """The recordings, those held out last."""
    diagnosis: Diagnosis | None
    document: Document | None
    """The diagnosis as JSON."""

    @property
    def primary_analyses(self) -> Mapping[str, ResidualAnalysis]:
        """Comparisons that judge the models: on the recordings held out, if there are any."""
        return self.held_out_analyses or self.analyses

    @property
    def recordings(self) -> tuple[Recording, ...]:
        """All recordings, those held out last."""
        return tuple(prediction.prepared.recording for _, _, prediction in self.predictions)

    @property
    def predictions(self) -> tuple[tuple[Mapping[str, ResidualAnalysis], int, prediction.Prediction], ...]:
        """For each recording: the analyses it is in, its index there, and the prediction of the first model."""
        groups = [self.analyses, *([self.held_out_analyses] if self.held_out_analyses else [])]
        return tuple(
            (group, index, predicted)
            for group in groups
            for index, predicted in enumerate(next(iter(group.values())).predictions)
        )

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as `ident compare --json` and `ident diagnose --json` print them."""
        groups = [(False, self.analyses), (True, self.held_out_analyses)]
        return {
            "schema": SCHEMA,
            "models": [{"name": name, "sha256": digest} for name, digest in self.digests.items()],
            "recordings": [source.model_dump(mode="json") for source in self.sources],
            "comparisons": [
                {"model": name, "held_out": held_out, "comparison": result.as_json()}
                for held_out, group in groups
                for name, result in group.items()
            ],
            "diagnosis": self.document.as_json() if self.document else None,
        }


def gather(request: ReportRequest, progress: Callable[[str], None]) -> ReportContents:
    """Compare every model with every recording, and diagnose the base model if that is asked for.

    Raises:
        BadInput: a file cannot be used, or they are not of the same rig.
    """
    effects = library(request.effect_files)
    paths = dict(zip(_display_names(request.models), request.models, strict=True))
    models = {name: model_file.load(path) for name, path in paths.items()}

    def compare_all(files: Sequence[Path]) -> dict[str, ResidualAnalysis]:
        results = {}
        for name, identified in models.items():
            progress(f"comparing {name}")
            results[name] = analysis.analyse(identified, prediction.predict(identified, files, effects))
        return results

    analyses = compare_all(request.recordings)
    held_out = compare_all(request.held_out) if request.held_out else {}
    diagnosis = None
    if request.diagnose:
        diagnosis = diagnose(request.recordings, request.held_out, effects, DiagnosisOptions(), progress)
    groups = [analyses, *([held_out] if held_out else [])]
    recordings = [
        predicted.prepared.recording for group in groups for predicted in next(iter(group.values())).predictions
    ]
    return ReportContents(
        request=request,
        models=models,
        digests={name: sha256(path) for name, path in paths.items()},
        analyses=analyses,
        held_out_analyses=held_out,
        sources=tuple(model_file.recording_source(recording) for recording in recordings),
        diagnosis=diagnosis,
        document=verdict.to_document(diagnosis) if diagnosis else None,
    )


def _display_names(paths: Sequence[Path]) -> list[str]:
    """Return the names of the files, with their folders where names are equal."""
    names = [path.name for path in paths]
    return [str(path) if names.count(path.name) > 1 else path.name for path in paths]
