"""A small residual analysis whose recording has a hostile name, gaps, and a late host."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.diagnosis.unknown.residual_test import scored_predictions
from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.identification import identify, prediction
from ident.identification.model_file import ModelFile
from ident.residuals.analysis import ResidualAnalysis, analyse
from recordings.recording import Recording

HOSTILE = "<script>alert(1)&b.mcap"


@pytest.fixture(scope="session")
def late(make: Callable[..., Recording], tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Two cycles of fig5b with a gap and a late cycle."""
    folder = tmp_path_factory.mktemp("late")
    recording = make("fig5b", cycles=2, rate=250.0, noise=0.02, path=folder / "b.mcap")
    position, lateness = recording.position.copy(), recording.lateness.copy()
    position[500:503, 1] = np.nan
    lateness[700] = 2e-3
    return replace(recording, position=position, lateness=lateness)


@pytest.fixture(scope="session")
def model(late: Recording, write: Callable[[Recording], Path]) -> ModelFile:
    write(late)
    options = identify.FitOptions("ls", estimators.settings("ls", {}), 0, "parallel", None)
    return identify.identify([late.path], (), options, lambda *_: None).model


@pytest.fixture(scope="session")
def analysis(model: ModelFile, late: Recording) -> ResidualAnalysis:
    predictions = prediction.predict(model, [late.path], library())
    result = analyse(model, *scored_predictions(model, predictions, library()))
    return replace(
        result,
        predictions=tuple(_renamed(predicted) for predicted in result.predictions),
        windows=tuple(replace(window, recording=HOSTILE) for window in result.windows),
    )


def _renamed(predicted: prediction.Prediction) -> prediction.Prediction:
    recording = replace(predicted.prepared.recording, path=Path(HOSTILE))
    return replace(predicted, prepared=replace(predicted.prepared, recording=recording))
