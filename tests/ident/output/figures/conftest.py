"""A small comparison, whose recording has a hostile name, gaps, and a host that was late."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from ident.estimation import estimators
from ident.identification import identify, prediction
from ident.identification.model import Model
from ident.residuals.analysis import ResidualAnalysis, analyse
from recordings.recording import Recording

HOSTILE = "<script>alert(1)&b.mcap"


@pytest.fixture(scope="session")
def late(make: Callable[..., Recording], tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """Two cycles of fig5b with a gap and a late cycle."""
    folder = tmp_path_factory.mktemp("late")
    made = make("fig5b", cycles=2, rate=250.0, noise=0.02, path=folder / "b.mcap")
    position, lateness = made.position.copy(), made.lateness.copy()
    position[500:503, 1] = np.nan
    lateness[700] = 2e-3
    return replace(made, position=position, lateness=lateness)


@pytest.fixture(scope="session")
def model(late: Recording, write: Callable[[Recording], Path]) -> Model:
    write(late)
    choices = identify.FitOptions("ls", estimators.settings("ls", {}), 0, "parallel", None)
    return identify.identify([late.path], None, choices, lambda *_: None).model


@pytest.fixture(scope="session")
def comparison(model: Model, late: Recording) -> ResidualAnalysis:
    found = analyse(model, prediction.predict(model, [late.path], library()))
    return replace(
        found,
        predictions=tuple(_renamed(one) for one in found.predictions),
        windows=tuple(replace(window, recording=HOSTILE) for window in found.windows),
    )


def _renamed(one: prediction.Prediction) -> prediction.Prediction:
    recording = replace(one.dataset.recording, path=Path(HOSTILE))
    return replace(one, dataset=replace(one.dataset, recording=recording))
