"""The result of a diagnosis as a user receives it."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.result import DiagnosisResult
from ident.diagnosis.document.verdict import to_document
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building

DRAG = 0.3


def drag(motion: Motion) -> Floats:
    return DRAG * motion.velocity * np.abs(motion.velocity)


def with_voltage(recording: Recording, path: Path) -> Recording:
    """The same torque as voltage of the map v |v|."""
    assert recording.effort is not None
    voltage = np.sign(recording.effort) * np.sqrt(np.abs(recording.effort))
    return replace(recording, voltage=voltage, effort=None, path=path)


@pytest.fixture(scope="module")
def result(write: Callable[[Recording], Path], tmp_path_factory: pytest.TempPathFactory) -> DiagnosisResult:
    """A diagnosis of two recordings with drag, by the effect that is planted alone."""
    folder = tmp_path_factory.mktemp("diagnosed")
    train, other = (
        write(with_voltage(building.record(noise=0.05, extra=drag, shape=shape), folder / f"{shape}.mcap"))
        for shape in (0, 1)
    )
    options = DiagnosisOptions(only=("quadratic_friction",))
    diagnosis = diagnose([train], [other], {"quadratic_friction": library()["quadratic_friction"]}, options)
    return DiagnosisResult(to_document(diagnosis), diagnosis, options)


def test_findings_and_verdict_are_those_of_the_document(result: DiagnosisResult) -> None:
    assert result.verdict == "missing-effect"
    (finding,) = result.findings
    assert (finding.effect, finding.status, finding.joints) == ("quadratic_friction", "asked-for", (1,))
    document = result.as_json()
    assert document["verdict"] == result.verdict
    assert [entry["effect"] for entry in document["findings"]] == ["quadratic_friction"]
    evidence = finding.evidence
    assert evidence.gain_ci95 is not None
    assert evidence.gain_ci95[0] <= evidence.gain <= evidence.gain_ci95[1]
    assert document["findings"][0]["evidence"]["decided_by"] == "held-out"


def test_model_with_the_effects_found_has_the_planted_parameters(result: DiagnosisResult) -> None:
    model = result.apply()
    assert model.file.effects == ("quadratic_friction",)
    values = [parameter.value for parameter in model.file.parameters]
    np.testing.assert_allclose(values, [*building.parameters(), DRAG], rtol=0.05)


def test_model_has_the_errors_that_the_document_states(result: DiagnosisResult) -> None:
    last = result.document.steps[-1].model_copy(update={"train_rms": (1.0,), "held_out_rms": (2.0,)})
    document = result.document.model_copy(update={"steps": (last,)})
    file, before = replace(result, document=document).apply().file, result.apply().file
    assert (file.train.fitted.rms, file.validate_ and file.validate_.fitted.rms) == ((1.0,), (2.0,))
    assert file.train.fitted.r2 == before.train.fitted.r2


def test_inputs_are_kept(result: DiagnosisResult) -> None:
    assert result.document.recordings == ("0.mcap", "1.mcap")
    assert result.options.only == ("quadratic_friction",)
