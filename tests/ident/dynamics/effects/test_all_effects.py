"""What every effect must keep to."""

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import library as library_package
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.effects.library import library, load
from ident.dynamics.motion import Motion
from ident.dynamics.structure import ModelStructure, Term
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
def course(make: object) -> PreparedRecording:
    recording: Recording = make(cycles=2, rate=250.0)  # type: ignore[operator]
    return prepare(recording, "parallel", 30.0)


@pytest.fixture(scope="module")
def view(course: PreparedRecording, truth: Floats) -> EffectInputs:
    return course.as_recorded.effect_inputs(course, truth)


def test_the_library_has_all_that_was_agreed() -> None:
    assert {
        "stribeck", "torque_offset", "asymmetric_viscous", "quadratic_friction", "load_dependent_friction",
        "presliding_hysteresis", "backlash", "joint_elasticity", "cogging", "joint_spring", "base_tilt",
        "payload_change", "rod_inertia", "arm_com_offset", "arm_mass_mismatch", "air_drag", "thermal_drift",
        "actuation_delay", "back_emf", "torque_gain_mismatch", "torque_map_exponent", "amplifier_deadband",
        "amplifier_saturation", "encoder_zero_offset", "encoder_eccentricity", "geometry_error",
    } <= set(LIBRARY)  # fmt: skip


@pytest.mark.parametrize("name", LIBRARY)
def test_it_explains_itself(name: str) -> None:
    effect = LIBRARY[name]
    for text in (effect.sentence, effect.symptom, effect.causes, effect.remedy, effect.equation):
        assert text.strip() == text != ""
    assert effect.sentence.endswith(".")
    assert effect.symptom.endswith(".")
    for quantity in (*Term(name, effect, (0, 1, 2)).local_parameters, *effect.shapes):
        assert quantity.meaning
        assert re.search(rf"\b{quantity.name}\b", effect.equation) or name in (
            "base_tilt",
            "backlash",
            "joint_elasticity",
        )
        assert "{" not in quantity.unit.format(effort="N", position="m")


@pytest.mark.parametrize("name", LIBRARY)
def test_its_searches_begin_inside_its_physical_ranges(name: str) -> None:
    effect = LIBRARY[name]
    searched = (*(effect.parameters if isinstance(effect, Signal) else ()), *effect.shapes)
    assert all(
        quantity.lower < quantity.upper for quantity in (*Term(name, effect, (0,)).local_parameters, *effect.shapes)
    )
    for quantity in searched:
        assert quantity.initial_guesses or effect.suggest
        assert all(quantity.lower <= start <= quantity.upper for start in quantity.initial_guesses)


def _shapes(name: str) -> list[dict[str, float]]:
    found = product(*(shape.initial_guesses or (20.0,) for shape in LIBRARY[name].shapes))
    return [dict(zip((shape.name for shape in LIBRARY[name].shapes), values, strict=True)) for values in found]


@pytest.mark.parametrize("name", ADDITIVE)
def test_columns_fit_the_motion_and_are_unknown_where_it_is(name: str, view: EffectInputs) -> None:
    effect = LIBRARY[name]
    assert isinstance(effect, Additive)
    for shapes in _shapes(name):
        columns = effect.columns(view, shapes)
        assert columns.shape == (*view.motion.position.shape, len(effect.coefficients))
        known = np.isfinite(view.motion.acceleration).all(axis=1) & np.isfinite(view.motion.direction).all(axis=1)
        assert np.isfinite(columns[known]).all()


def _motion_with_gap(view: EffectInputs) -> EffectInputs:
    motion = Motion(
        *(getattr(view.motion, field).copy() for field in ("position", "velocity", "acceleration", "direction"))
    )
    for field in ("position", "velocity", "acceleration", "direction"):
        getattr(motion, field)[700] = np.nan
    return EffectInputs(view.rig, view.rate, view.time, motion, view.rigid_at, view.bandwidth, view.parameters)


@pytest.mark.parametrize("name", ADDITIVE)
def test_a_gap_stays_a_gap(name: str, view: EffectInputs) -> None:
    effect = LIBRARY[name]
    assert isinstance(effect, Additive)
    columns = effect.columns(_motion_with_gap(view), _shapes(name)[0])
    assert np.isnan(columns[700]).all()
    assert np.isfinite(columns[750:800]).all()


@pytest.mark.parametrize("name", SIGNALS)
def test_a_distortion_of_nothing_is_none(name: str, course: PreparedRecording, truth: Floats) -> None:
    composition = ModelStructure(
        course.as_recorded.mechanism, course.as_recorded.rig, (Term(name, LIBRARY[name], (0, 1, 2)),)
    )
    x = np.zeros(len(composition.parameters))
    x[: len(truth)] = truth
    x[len(truth) + composition.terms[0].instances * len(composition.terms[0].local_parameters) :] = list(
        _shapes(name)[0].values()
    )
    evaluator = TorquePredictor(course)
    bare = ModelStructure(course.as_recorded.mechanism, course.as_recorded.rig)
    computed, expected = evaluator.torque(composition, x), evaluator.torque(bare, truth)
    known = np.isfinite(computed)
    np.testing.assert_allclose(computed[known], expected[known], atol=1e-6)


@pytest.mark.parametrize("name", LIBRARY)
def test_what_was_planted_is_found(name: str, course: PreparedRecording, truth: Floats) -> None:
    """The engine's own columns plus the mechanism give back the parameters from which they were made."""
    effect = LIBRARY[name]
    joints = (0, 1, 2) if effect.whole_robot else (1,)
    composition = ModelStructure(course.as_recorded.mechanism, course.as_recorded.rig, (Term(name, effect, joints),))
    x = np.zeros(len(composition.parameters))
    x[: len(truth)] = truth
    shapes = _shapes(name)[len(_shapes(name)) // 2]
    own = [_planted(quantity.lower, quantity.initial_guesses) for quantity in composition.terms[0].local_parameters]
    x[len(truth) :] = [*own, *shapes.values()]
    evaluator = TorquePredictor(course)
    made = evaluator.torque(composition, x)
    object.__setattr__(course.dataset, "torque", np.where(course.usable, made, np.nan))
    start = x.copy()
    start[len(truth) :] *= np.where([entry.free for entry in composition.parameters[len(truth) :]], 1.15, 1.0)
    found = nonlinear_least_squares([evaluator], composition, start, [np.where(course.usable, 1.0, 0.0)])
    left = found.residuals[0][np.isfinite(found.residuals[0])]
    size = made - evaluator.torque(ModelStructure(course.as_recorded.mechanism, course.as_recorded.rig), truth)
    assert np.sqrt(np.mean(left**2)) < 0.03 * np.sqrt(np.nanmean(size**2))


def _planted(lower: float, starts: tuple[float, ...]) -> float:
    return starts[0] if starts else 0.5


def test_a_file_of_the_user_is_an_effect(tmp_path: Path) -> None:
    path = tmp_path / "my_own.py"
    path.write_text((Path(library_package.__file__).parent / "torque_offset.py").read_text())
    assert "my_own" in library([path])


@pytest.mark.parametrize(
    ("name", "text", "found"),
    [
        ("stribeck.py", "effect = 1", "name of its own"),
        ("mine.py", "effect = 1", "int found"),
        ("mine.py", "1 / 0", "ZeroDivisionError"),
        ("mine.txt", "", "Python file"),
    ],
)
def test_what_is_no_effect_is_refused(tmp_path: Path, name: str, text: str, found: str) -> None:
    (tmp_path / name).write_text(text)
    with pytest.raises(BadInput, match=found):
        library([tmp_path / name])


def test_an_unknown_name_is_refused() -> None:
    with pytest.raises(BadInput, match="torque_offset"):
        load("magic")


def test_what_an_amplifier_does_is_seen_in_its_command_only() -> None:
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
