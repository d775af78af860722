"""Inputs and options of a diagnosis: recordings, cut-off, validation data, requested effects."""

import gc
import weakref
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions, diagnose, prepare_inputs
from ident.diagnosis.document import verdict
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from tests.ident import building
from tests.ident.conftest import TRUTH

SAMPLE = "recordings/samples/fig5a.mcap"


@pytest.mark.parametrize(
    ("file", "options", "reason"),
    [
        ("no such file", {"only": ("frobnicate",)}, "a name of the library expected, 'frobnicate' found"),
        ("no such file", {"without": ("frobnicate",)}, "a name of the library expected, 'frobnicate' found"),
        (SAMPLE, {"only": ("stribeck",), "without": ("stribeck",)}, "'stribeck' found: Left out by the user"),
        (SAMPLE, {"only": ("amplifier_saturation",)}, "can show expected, 'amplifier_saturation' found: "),
    ],
)
def test_impossible_requests_are_refused_with_the_reason(file: str, options: dict[str, Any], reason: str) -> None:
    with pytest.raises(BadInput, match=reason):
        diagnose([Path(file)], [], library(), DiagnosisOptions(**options))


def test_effect_that_is_left_out_is_not_tested() -> None:
    options = DiagnosisOptions(only=("stribeck",), without=("air_drag", "rod_inertia"))
    document = verdict.to_document(diagnose([Path(SAMPLE)], [], library(), options))
    rejected = {entry.effect: (entry.status, entry.why) for entry in document.rejected}
    assert rejected["air_drag"] == rejected["rod_inertia"] == ("not-tested", "Left out by the user.")
    assert document.steps[-1].effects == ("stribeck",)


def test_recordings_of_a_diagnosis_are_freed_with_it() -> None:
    gc.disable()  # it comes too seldom for arrays: a process of many diagnoses would grow to gigabytes
    try:
        diagnosis = diagnose([Path(SAMPLE)], [], library(), DiagnosisOptions(only=("stribeck",)))
        recording = weakref.ref(diagnosis.split.recordings[0])
        del diagnosis
        assert recording() is None
    finally:
        gc.enable()


def test_all_validation_recordings_are_scored_and_not_fitted(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    files = [
        write(make(trajectory, rate=250.0, cycles=2, noise=0.01, path=tmp_path / f"{trajectory}.mcap"))
        for trajectory in ("fig5a", "fig5b", "excitation")
    ]
    split = prepare_inputs(files[:1], files[1:], library(), DiagnosisOptions()).split
    assert [bool(rows.any()) for rows in split.train] == [True, False, False]
    assert [bool(rows.any()) for rows in split.test] == [False, True, True]
    assert verdict.describe_test_data(split) == "other recordings: fig5b.mcap, excitation.mcap"
    single = prepare_inputs(files[:1], files[1:2], library(), DiagnosisOptions()).split
    assert verdict.describe_test_data(single) == "another recording: fig5b.mcap"
    with pytest.raises(BadInput, match="begin with the same data"):
        prepare_inputs(files[:1], files[:1], library(), DiagnosisOptions())


def test_validation_recordings_that_disagree_are_named(
    make: Callable[..., Recording], write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    (tmp_path / "other").mkdir()
    changed = TRUTH * np.where(np.arange(len(TRUTH)) == 0, 1.2, 1.0)
    files = [
        write(make("fig5a", rate=250.0, cycles=2, noise=0.01, path=tmp_path / "a.mcap")),
        write(make("fig5b", rate=250.0, cycles=2, noise=0.01, path=tmp_path / "b.mcap")),
        write(
            make("fig5b", rate=250.0, cycles=2, noise=0.01, parameters=changed, path=tmp_path / "other" / "b.mcap")
        ),
    ]
    effects = {"rod_inertia": library()["rod_inertia"]}
    document = verdict.to_document(diagnose(files[:1], files[1:], effects, DiagnosisOptions()))
    (warning,) = [warning for warning in document.warnings if "disagree" in warning]
    assert f"{tmp_path / 'b.mcap'}: 1" in warning
    assert str(tmp_path / "other" / "b.mcap") in document.held_out
    single = verdict.to_document(diagnose(files[:1], files[1:2], effects, DiagnosisOptions()))
    assert not [warning for warning in single.warnings if "disagree" in warning]


def test_held_out_rows_outside_of_the_travel_of_a_curve_are_not_scored(
    write: Callable[[Recording], Path], tmp_path: Path
) -> None:
    """The friction rises where the training never was, so that no curve learned from it is right there."""

    def rubbing(motion: Motion) -> Floats:
        product: Floats = (0.3 * np.sin(3 * motion.position) + 2 * motion.position.clip(1.2)) * motion.direction
        return product

    files = [
        write(replace(building.record(noise=0.02, seed=i, extra=rubbing, size=size), path=tmp_path / f"{i}.mcap"))
        for i, size in enumerate((0.6, 0.9))
    ]
    name = "position_dependent_friction"
    diagnosis = diagnose(files[:1], files[1:], {name: library()[name]}, DiagnosisOptions())
    document = verdict.to_document(diagnosis)
    assert document.verdict == "missing-effect"
    (warning,) = [warning for warning in document.warnings if "not scored" in warning]
    assert (
        "(joint 1) are not scored, where the model says nothing: outside of the travel of the training data"
        in warning
    )
    last = document.steps[-1]
    assert last.held_out_rms[0] < 1.1 * document.noise_rms[0] < 2 * last.held_out_rms_all[0]
