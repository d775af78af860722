"""Effect files written for earlier versions load unchanged."""

from pathlib import Path

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects import base
from ident.dynamics.effects.library import load
from ident.dynamics.effects.user_files import from_file
from ident.estimation.predicted_torque import TorquePredictor
from recordings.errors import BadInput
from recordings.recording import Recording

TEXTS = 'sentence="It rubs.", looks="A bump.", causes="dirt", remedy="clean it", equation="a", axis="position"'
PRESENT_TEXTS = TEXTS.replace("looks", "symptom")
ADDITIVE = f"""
effect = Additive({TEXTS}, always_true=True, coefficients=(Quantity(name="a", unit="1", meaning="it"),),
                  columns=lambda view, shapes: view.rigid[:, :, None])
"""
EVERYTHING = f"""
import platform
import ident.effects
import ident.signals as filters
from ident.signals import stretches
from ident import compiled, view as inputs
from ident.effects import NEVER, Axis, Effect, Quantity, Shapes, Signal, Suggestion, Values, is_never
from ident.effects.stribeck import columns as bump
from ident.forearms import GRAVITY
from ident.motion import Motion
from ident.platform import Platform
from ident.view import View


def report(torque: object, view: View, values: Values) -> object:
    from ident.torque_map import torque_from_voltage, voltage_from_torque

    assert isinstance(view, inputs.View)
    voltage = voltage_from_torque(torque, map_=view.rig.torque)
    arms = view.calmed().arms(0.3)
    half = values["b"]
    moved = arms.with_play(view.motion, half=half) - arms.following(view.motion)
    assert view.calmed(0.5).every(2).rigid.shape == torque[::2].shape
    assert arms.on_springs(view.motion, 0 * half, ratio=0.1).shape == bump(view, {{"v_s": 0.1}})[..., 0].shape
    return torque_from_voltage(voltage, torque=view.rig.torque) + moved


effect = ident.effects.Signal(
    {TEXTS},
    valleys=3,
    parameters=(Quantity(name="b", unit="rad", meaning="gap", starts=(0.1,)),),
    shapes=(Quantity(name="t", unit="s", meaning="instant", starts=(NEVER,), open="upper"),),
    report=compiled.__name__ and report,
)
assert effect.looks == effect.symptom
assert platform.python_version()
assert len(filters.low_pass(10.0, 100.0)) == 31
assert effect.parameters[0].starts == (0.1,)
assert is_never(effect.shapes[0].starts[0], "s")
"""


@pytest.fixture(scope="module")
def inputs(make: object, truth: np.ndarray) -> EffectInputs:
    recording: Recording = make(cycles=1, rate=100.0)  # type: ignore[operator]
    prepared = prepare(recording, "parallel", 20.0)
    return TorquePredictor(prepared).effect_inputs(prepared.base_structure, truth)


def written(folder: Path, text: str) -> Path:
    path = folder / "mine.py"
    path.write_text(text)
    return path


@pytest.mark.parametrize(
    "imports",
    [
        "from ident.effects import Additive, Quantity",
        "from ident.effects import *",
        "from ident import effects\nAdditive, Quantity = effects.Additive, effects.Quantity",
        "import ident.effects\nAdditive, Quantity = ident.effects.Additive, ident.effects.Quantity",
        "import ident.effects as e\nAdditive, Quantity = e.Additive, e.Quantity",
        "def late():\n    from ident.effects import Additive, Quantity\n    return Additive, Quantity\n"
        "Additive, Quantity = late()",
    ],
)
def test_earlier_imports_and_keywords_are_translated(tmp_path: Path, inputs: EffectInputs, imports: str) -> None:
    effect = from_file(written(tmp_path, imports + ADDITIVE))
    assert isinstance(effect, base.Additive)
    assert effect.symptom == "A bump."
    assert effect.mandatory
    np.testing.assert_array_equal(effect.columns(inputs, {})[:, :, 0], inputs.rigid)


def test_everything_that_an_earlier_file_may_use_still_answers(tmp_path: Path, inputs: EffectInputs) -> None:
    effect = from_file(written(tmp_path, EVERYTHING))
    assert isinstance(effect, base.Signal)
    assert (effect.multistart, effect.shapes[0].implausible_bound) == (3, "upper")
    assert effect.parameters[0].initial_guesses == (0.1,)
    assert effect.report
    reported = effect.report(np.ones_like(inputs.rigid), inputs, {"b": np.zeros(3)})
    np.testing.assert_allclose(reported[np.isfinite(reported)], 1.0, atol=1e-9)
    assert np.isfinite(reported).mean() > 0.8


def test_an_effect_of_the_library_may_be_changed(tmp_path: Path) -> None:
    text = "from dataclasses import replace\nfrom ident.effects import load\n"
    text += "effect = replace(load('stribeck'), causes='x')"
    effect = from_file(written(tmp_path, text))
    assert (effect.causes, effect.symptom) == ("x", load("stribeck").symptom)


def test_a_learned_curve_has_the_same_torque(tmp_path: Path, inputs: EffectInputs) -> None:
    text = """
from ident.stand_in import Curve, effect_of
effect = effect_of(
    [Curve(joint=2, variable='position', of_joint=3, times='velocity', knots=(-1.0, 1.0), values=(2.0, 2.0))]
)
"""
    effect = from_file(written(tmp_path, text))
    assert isinstance(effect, base.Additive)
    np.testing.assert_allclose(effect.columns(inputs, {})[:, 1, 0], 2.0 * inputs.motion.velocity[:, 1])


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("from ident.effects import Magic", "ident.effects.Magic"),
        ("import ident.course", "ident.course"),
        ("from ident.evaluation import Evaluator", "ident.evaluation"),
    ],
)
def test_an_import_of_what_is_gone_is_refused(tmp_path: Path, text: str, name: str) -> None:
    with pytest.raises(BadInput, match=rf"mine\.py: imports of what docs/.* lists expected, {name} found"):
        from_file(written(tmp_path, text))


def test_an_attribute_that_is_gone_is_named(tmp_path: Path, inputs: EffectInputs) -> None:
    effect = from_file(
        written(tmp_path, ("from ident.effects import Additive, Quantity" + ADDITIVE).replace("rigid", "torque"))
    )
    assert isinstance(effect, base.Additive)
    with pytest.raises(BadInput, match="AttributeError 'View' object has no attribute 'torque'; mend the file"):
        effect.columns(inputs, {})


def test_a_file_with_present_names_is_left_as_it_is(tmp_path: Path) -> None:
    text = "from ident.dynamics.effects.base import Additive, Quantity" + ADDITIVE
    text = text.replace(TEXTS, PRESENT_TEXTS).replace("always_true", "mandatory")
    assert type(from_file(written(tmp_path, text))) is base.Additive
