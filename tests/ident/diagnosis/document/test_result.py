"""The result of a diagnosis as a user receives it, and the model file of its last model."""

import pickle
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import ident
from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose
from ident.diagnosis.document.result import METHOD, DiagnosisResult, model_file
from ident.diagnosis.document.verdict import to_document
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.split.split_data import rms
from ident.diagnosis.unknown.residual_test import estimate_unexplained
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building


def test_applied_model_is_that_of_the_document(write: Callable[[Recording], Path], tmp_path: Path) -> None:
    """Two recordings with drag, of the voltage of the map v |v|, by the effect that is planted alone."""
    files = []
    for shape in (0, 1):
        recording = building.record(noise=0.05, extra=building.drag, shape=shape)
        assert recording.effort is not None
        voltage = np.sign(recording.effort) * np.sqrt(np.abs(recording.effort))
        files.append(write(replace(recording, voltage=voltage, effort=None, path=tmp_path / f"{shape}.mcap")))
    name, options = "quadratic_friction", DiagnosisOptions(only=("quadratic_friction",))
    diagnosis = diagnose(files[:1], files[1:], {name: library()[name]}, options)
    result = DiagnosisResult(to_document(diagnosis), diagnosis, options)
    (finding,) = result.findings
    assert (finding.effect, finding.status, finding.joints) == (name, "asked-for", (1,))
    assert finding.evidence.decided_by == "held-out"
    assert finding.evidence.gain_ci95 is not None
    assert finding.evidence.gain_ci95[0] <= finding.evidence.gain <= finding.evidence.gain_ci95[1]
    document = result.as_json()
    assert document["verdict"] == result.verdict == "missing-effect"
    assert [entry["effect"] for entry in document["findings"]] == [name]
    assert result.document.recordings == ("0.mcap", "1.mcap")
    file, last = result.model.file, result.document.steps[-1]
    assert file.effects == (name,)
    values = [parameter.value for parameter in file.parameters]
    np.testing.assert_allclose(values, [*building.parameters(), building.DRAG], rtol=0.05)
    assert file.validate_ is not None
    assert (file.train.fitted.rms, file.validate_.fitted.rms) == (last.train_rms, last.held_out_rms)


def test_shares_of_effects_on_different_joints_add_up_to_the_fall_of_the_whole_robot(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    def drag_and_spring(motion: Motion) -> Floats:
        return building.drag(motion) * [1, 0] + motion.position * [0, 1]

    recordings = (building.record(2, noise=0.05, extra=drag_and_spring, shape=shape) for shape in (0, 1))
    files = [write(replace(each, path=tmp_path / f"{i}.mcap")) for i, each in enumerate(recordings)]
    effects = {name: library()[name] for name in ("quadratic_friction", "joint_spring")}
    document = to_document(diagnose(files[:1], files[1:], effects, DiagnosisOptions()))
    assert {each.effect: each.joints for each in document.findings} == {
        "quadratic_friction": (1,),
        "joint_spring": (2,),
    }
    assert sum(each.share or 0.0 for each in document.findings) == pytest.approx(1.0, abs=0.02)
    for each in document.findings:
        assert each.share == pytest.approx(0.5, abs=0.05)
        assert f"It takes {each.share:.0%} " in each.why
        assert "over all joints" in each.why


def test_a_mandatory_effect_that_does_not_show_stands_in_the_steps_alone(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    recordings = (building.record(noise=0.05, shape=shape) for shape in (0, 1))
    files = [write(replace(each, path=tmp_path / f"{i}.mcap")) for i, each in enumerate(recordings)]
    effects = {"quadratic_friction": library()["quadratic_friction"].changed(mandatory=True)}
    document = to_document(diagnose(files[:1], files[1:], effects, DiagnosisOptions()))
    assert document.steps[-1].effects == ("quadratic_friction",)
    assert (document.findings, document.likely, document.rejected) == ((), (), ())


def test_model_file_has_the_values_intervals_and_errors_of_the_model() -> None:
    """An effect with a shape."""

    def stribeck(motion: Motion) -> Floats:
        return np.sign(motion.velocity) * np.exp(-((motion.velocity / 0.3) ** 2))

    train, held_out = (building.record(noise=0.05, extra=stribeck, shape=shape, seed=shape) for shape in (0, 1))
    split, structure = building.split([train], [held_out]), building.structure(train, "stribeck")
    model = FittedModel(split, split.fit(structure, np.array([*building.parameters(), 0.5, 0.5])))
    file = model_file(model, estimate_unexplained(model, ()))
    names = [entry.name for entry in structure.parameters]
    values = {entry.name: entry.value for entry in file.all_parameters}
    assert values == dict(zip(names, model.solution.x.tolist(), strict=True))
    assert [entry.name for entry in file.searched] == ["stribeck.v_s"]
    assert file.terms[0].shapes["v_s"] == values["stribeck.v_s"]
    assert file.method.name == METHOD
    truth = {"stribeck.a1": 1.0, "stribeck.v_s": 0.3, "I_1": building.INERTIA}
    for entry in file.all_parameters:
        assert entry.shape_ci95 is not None
        assert entry.shape_ci95 == pytest.approx(entry.ci95, rel=1e-12), "the torque was measured"
        width = entry.shape_ci95[1] - entry.shape_ci95[0]
        assert abs(entry.value - truth.get(entry.name, entry.value)) < 2 * width
    assert file.validate_ is not None
    assert file.train.fitted.rms == pytest.approx(tuple(rms(model.residuals, model.split.train)))
    assert file.validate_.fitted.rms == pytest.approx(tuple(rms(model.residuals, model.split.test)))
    assert file.residual_test is not None
    assert file.residual_test.noise_rms == tuple(model.noise_floor.rms.tolist())
    assert file.residual_test.verdict == "within-noise"


def test_a_pickle_carries_the_recordings_and_computes_the_rest_again() -> None:
    train, other = (building.record(noise=0.05, extra=building.drag, shape=shape, seed=shape) for shape in (0, 1))
    result = ident.diagnose(train, validate=other, only="quadratic_friction")
    assert result.propose() is None
    again = pickle.loads(pickled := pickle.dumps(result))
    assert len(pickled) < 3 * sum(len(pickle.dumps(each)) for each in (train, other))
    assert again.as_json() == result.as_json()
    assert again.model.parameters == result.model.parameters
    assert again.propose() is None
    for found, expected in zip(again.diagnosis.model.residuals, result.diagnosis.model.residuals, strict=True):
        np.testing.assert_allclose(found, expected, atol=1e-9)
    assert again.plot() == result.plot()


def test_applied_model_predicts_the_ripple_above_the_low_pass(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    def ripple(motion: Motion) -> Floats:
        return 0.3 * np.sin(200 * motion.position)

    files = []
    for shape in (0, 1):
        recording = building.record(noise=0.05, extra=ripple, shape=shape, rate=500.0)
        files.append(write(replace(recording, path=tmp_path / f"{shape}.mcap")))
    diagnosis = ident.diagnose(files[:1], validate=files[1:])
    assert "cogging" in [finding.effect for finding in diagnosis.findings]
    fitted = diagnosis.model
    assert fitted.file.effects == diagnosis.document.steps[-1].effects
    fitted.save(tmp_path / "m.json")
    angle = np.linspace(0.1, 0.3, 400)[:, None]
    torque = ident.load_model(tmp_path / "m.json").torque(angle, np.ones_like(angle), np.zeros_like(angle))[:, 0]
    assert np.ptp(torque) == pytest.approx(0.6, rel=0.1)
