"""Contents of a report: models, recordings, residual analyses and diagnosis; of a diagnosis alone no models."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.diagnosis.document.result import DiagnosisResult, diagnosed
from ident.diagnosis.unknown.residual_test import scored_predictions
from ident.dynamics.effects.base import Effect
from ident.dynamics.effects.library import library
from ident.estimation.axis_response import AxisResponse, axis_response
from ident.identification import model_file, prediction
from ident.identification.model_file import ModelFile, RecordingSource
from ident.residuals import analysis
from ident.residuals.analysis import ResidualAnalysis
from recordings.files import sha256
from recordings.reader import Source
from recordings.recording import Recording

SCHEMA = 2


@dataclass(frozen=True)
class ReportRequest:
    """Files and options of the command."""

    models: tuple[Path, ...]
    recordings: tuple[Source, ...]
    held_out: tuple[Source, ...]
    effect_files: tuple[Path, ...]
    diagnose: bool
    base_model: Path | None = None
    """The model whose effects are the start of the diagnosis."""
    responses: tuple[Path, ...] = ()
    """Recordings of `daq response`."""
    accept: tuple[str, ...] = ()
    """Kinds of data problems in spite of which the recordings are used."""


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
    recordings: tuple[Recording, ...]
    """All recordings, those held out last; in a diagnosis alone an excerpt of each long one."""
    sources: tuple[RecordingSource, ...]
    """Their files."""
    diagnosis: DiagnosisResult | None
    effects: Mapping[str, Effect]
    """Those of the library and of the user, by name."""
    responses: tuple[AxisResponse, ...] = ()
    """Frequency responses of single axes."""

    @property
    def primary_analyses(self) -> Mapping[str, ResidualAnalysis]:
        """Comparisons that judge the models: on the recordings held out, if there are any."""
        return self.held_out_analyses or self.analyses

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
            "diagnosis": self.diagnosis.as_json() if self.diagnosis else None,
            "responses": [response.as_json() for response in self.responses],
        }


def gather(
    request: ReportRequest, progress: Callable[[str], None], effects: Mapping[str, Effect] | None = None
) -> ReportContents:
    """Compare every model with every recording, and diagnose the base model if that is asked for.

    effects: by name; None: those of the library and of the `effect_files`.

    Raises:
        BadInput: a file cannot be used, or they are not of the same rig.
    """
    effects = library(request.effect_files) if effects is None else effects
    responses = tuple(map(axis_response, request.responses))
    names = [path.name for path in request.models]
    models = {  # models of equal names are called by their paths
        path.name if names.count(path.name) == 1 else str(path): model_file.load(path) for path in request.models
    }

    def compare_all(files: Sequence[Source]) -> dict[str, ResidualAnalysis]:
        results = {}
        for name, identified in models.items():
            progress(f"comparing {name}")
            predictions = prediction.predict(identified, files, effects, request.accept)
            results[name] = analysis.analyse(identified, *scored_predictions(identified, predictions, effects))
        return results

    analyses = compare_all(request.recordings)
    held_out = compare_all(request.held_out) if request.held_out else {}
    diagnosis = None
    if request.diagnose:
        options = DiagnosisOptions(accept=request.accept)
        diagnosis = diagnosed(request.recordings, request.held_out, effects, options, progress)
    return assemble(request, models, analyses, held_out, diagnosis, responses, effects)


def assemble(
    request: ReportRequest,
    models: Mapping[str, ModelFile] = {},
    analyses: Mapping[str, ResidualAnalysis] = {},
    held_out_analyses: Mapping[str, ResidualAnalysis] = {},
    diagnosis: DiagnosisResult | None = None,
    responses: tuple[AxisResponse, ...] = (),
    effects: Mapping[str, Effect] | None = None,
) -> ReportContents:
    """Add the recordings and the digests of all files to results; models and their analyses by name."""
    first_results = [next(iter(group.values())) for group in (analyses, held_out_analyses) if group]
    prepared = [predicted.prepared for result in first_results for predicted in result.predictions]
    if diagnosis and not prepared:
        prepared = list(diagnosis.diagnosis.split.recordings)
    recordings = {each.recording.path: each.recording for each in prepared}
    return ReportContents(
        request=request,
        models=models,
        digests=dict(zip(models, map(sha256, request.models), strict=True)),
        analyses=analyses,
        held_out_analyses=held_out_analyses,
        recordings=tuple(recordings.values()),
        sources=tuple(map(model_file.recording_source, recordings.values())),
        diagnosis=diagnosis,
        effects=library(request.effect_files) if effects is None else effects,
        responses=responses,
    )
