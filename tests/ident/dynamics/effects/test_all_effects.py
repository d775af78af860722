"""Requirements on every effect."""

import re
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from ident.basics import slicing
from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.effects.library import library
from ident.dynamics.effects.validation import validation_error
from ident.dynamics.structure import Term
from ident.estimation.nonlinear_fit import nonlinear_least_squares
from ident.estimation.predicted_torque import TorquePredictor
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Rig, simulated_rig

LIBRARY = library()
ADDITIVE = [name for name, effect in LIBRARY.items() if isinstance(effect, Additive)]
SIGNALS = [name for name, effect in LIBRARY.items() if isinstance(effect, Signal)]
BASE = ("viscous", "coulomb")


@pytest.fixture(scope="module")
def prepared(make: object) -> PreparedRecording:
    recording: Recording = make(cycles=2, rate=250.0)  # type: ignore[operator]
    warming = np.linspace(20.0, 45.0, len(recording.time))
    recording = replace(recording, extra={f"temperature_{joint}": warming for joint in (1, 2, 3)})
    return prepare(recording, "parallel", 30.0)


@pytest.fixture(scope="module")
def inputs(prepared: PreparedRecording, truth: Floats) -> EffectInputs:
    return TorquePredictor(prepared).effect_inputs(prepared.base_structure, truth)


@pytest.mark.parametrize("name", LIBRARY)
def test_every_effect_is_documented(name: str) -> None:
    effect = LIBRARY[name]
    assert validation_error(effect) is None
    assert effect.sentence.endswith(".")
    assert effect.record
    assert effect.symptom.endswith(".")
    for quantity in (*Term(name, effect, (0, 1, 2)).local_parameters, *effect.shapes):
        assert quantity.meaning
        assert re.search(rf"\b{quantity.name}\b", effect.equation) or name in (
            "base_tilt",
            "backlash",
            "joint_elasticity",
        )
        assert "{" not in quantity.unit.format(effort="N", position="m", turn="2π m")


_WITHOUT_GUESSES = {"t_c": 1.0, "t_e": 1e9, "t_r": 0.4}
"""Values of shapes that only a residual suggests."""


def _shapes(name: str) -> list[dict[str, float]]:
    combinations = product(
        *(shape.initial_guesses or (_WITHOUT_GUESSES.get(shape.name, 20.0),) for shape in LIBRARY[name].shapes)
    )
    return [dict(zip((shape.name for shape in LIBRARY[name].shapes), values, strict=True)) for values in combinations]


@pytest.mark.parametrize("name", ADDITIVE)
def test_columns_are_known_where_the_motion_is_and_nowhere_else(name: str, inputs: EffectInputs) -> None:
    effect = LIBRARY[name]
    assert isinstance(effect, Additive)
    gapped = slicing.along_time(inputs.motion, np.arange(len(inputs.time)))
    for signal in (gapped.position, gapped.velocity, gapped.acceleration, gapped.direction):
        signal[700] = np.nan
    known = np.isfinite(gapped.acceleration).all(axis=1) & np.isfinite(gapped.direction).all(axis=1)
    for shapes in _shapes(name):
        columns = effect.columns(replace(inputs, motion=gapped), shapes)
        assert columns.shape == (*gapped.position.shape, len(effect.parameters))
        assert np.isfinite(columns[known]).all()
        assert np.isnan(columns[700]).all()


@pytest.mark.parametrize("name", SIGNALS)
def test_a_signal_with_zero_parameters_changes_nothing(name: str, prepared: PreparedRecording, truth: Floats) -> None:
    bare = prepared.base_structure
    structure = bare.with_term(Term(name, LIBRARY[name], (0, 1, 2)))
    x = np.zeros(len(structure.parameters))
    x[: len(truth)] = truth
    x[len(truth) + structure.terms[0].instances * len(structure.terms[0].local_parameters) :] = list(
        _shapes(name)[0].values()
    )
    predictor = TorquePredictor(prepared)
    computed, expected = predictor.torque(structure, x), predictor.torque(bare, truth)
    known = np.isfinite(computed)
    np.testing.assert_allclose(computed[known], expected[known], atol=1e-6)


@pytest.mark.parametrize("name", LIBRARY)
def test_planted_parameters_are_recovered(name: str, prepared: PreparedRecording, truth: Floats) -> None:
    """A fit to torque that was computed from known parameters recovers it."""
    effect = LIBRARY[name]
    joints = (0, 1, 2) if effect.whole_robot else (1,)
    bare = prepared.base_structure
    structure = bare.with_term(Term(name, effect, joints))
    x = np.zeros(len(structure.parameters))
    x[: len(truth)] = truth
    shapes = _shapes(name)[len(_shapes(name)) // 2]
    local = [_first_guess(quantity.initial_guesses) for quantity in structure.terms[0].local_parameters]
    x[len(truth) :] = [*local, *shapes.values()]
    predictor = TorquePredictor(prepared)
    planted = predictor.torque(structure, x)
    object.__setattr__(prepared, "torque", np.where(prepared.usable, planted, np.nan))
    start = x.copy()
    start[len(truth) :] *= np.where([entry.free for entry in structure.parameters[len(truth) :]], 1.15, 1.0)
    solution = nonlinear_least_squares([predictor], structure, start, [np.where(prepared.usable, 1.0, 0.0)])
    residual = solution.residuals[0][np.isfinite(solution.residuals[0])]
    contribution = planted - predictor.torque(bare, truth)
    assert np.sqrt(np.mean(residual**2)) < 0.03 * np.sqrt(np.nanmean(contribution**2))


def _first_guess(guesses: tuple[float, ...]) -> float:
    return guesses[0] if guesses else 0.5


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("stribeck.py", "effect = 1", "name of its own"),
        ("mine.py", "effect = 1", "int found"),
        ("mine.py", "1 / 0", "ZeroDivisionError"),
        ("mine.py", "import sys; sys.exit(0)", r"mine\.py: SystemExit 0"),
        ("mine.txt", "", "Python file"),
    ],
)
def test_a_file_without_an_effect_is_refused(tmp_path: Path, name: str, text: str, message: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(BadInput, match=message):
        library([tmp_path / name])


def test_amplifier_effects_are_observable_only_in_a_reported_command() -> None:
    motor = simulated_rig()
    drives = [
        drive.model_copy(update={"voltage": drive.voltage.model_copy(update={"kind": "command"})})
        for drive in motor.drives
    ]
    command: Rig = motor.model_copy(update={"drives": tuple(drives)})
    for name in ("amplifier_deadband", "amplifier_saturation"):
        assert LIBRARY[name].unobservable(motor, False)
        assert not LIBRARY[name].unobservable(command, False)
        assert LIBRARY[name].unobservable(command, True)
