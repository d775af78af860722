"""What goes wrong in an effect file of the user is said with its name."""

from pathlib import Path

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.effects.user_files import from_file
from recordings.errors import BadInput
from recordings.recording import Floats, Recording

HEAD = """
import sys
import numpy as np
from ident.dynamics.effects.base import Additive, Quantity, Signal

TEXT = dict(sentence="It rubs.", symptom="A bump.", causes="dirt", remedy="clean it", equation="a", axis="position")
"""
ADDITIVE = """
def columns(view, shapes):
    {body}

effect = Additive(**TEXT, coefficients=(Quantity(name="a", unit="1", meaning="it"),), columns=columns)
"""


@pytest.fixture(scope="module")
def view(make: object, truth: Floats) -> EffectInputs:
    recording: Recording = make(cycles=1, rate=250.0)  # type: ignore[operator]
    course = prepare(recording, "parallel", 30.0)
    return course.as_recorded.effect_inputs(course, truth)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("return 1 / 0", "columns: ZeroDivisionError division by zero; mend the file"),
        ("sys.exit(0)", "SystemExit 0"),
        ("return columns(view, shapes)", "RecursionError"),
        ("return 'x'", "an array of real numbers .* expected, str found"),
        ("return view.motion.position", "expected, float64 .* found"),
        ("return 1j * view.motion.position[..., None]", "complex128"),
        ("return np.full((*view.motion.position.shape, 1), np.nan)", "finite numbers where the motion is known"),
        ("view.motion.velocity[...] *= 0.5", "read-only"),
        ("raise ValueError('two' + chr(10) + 'lines')", "ValueError two lines; mend"),
    ],
)
def test_a_function_that_fails_is_named(tmp_path: Path, view: EffectInputs, body: str, expected: str) -> None:
    path = tmp_path / "mine.py"
    path.write_text(HEAD + ADDITIVE.format(body=body))
    effect = from_file(path)
    assert isinstance(effect, Additive)
    before = view.motion.velocity.copy()
    with pytest.raises(BadInput, match=rf"effect file .*mine\.py: .*{expected}"):
        effect.columns(view, {})
    np.testing.assert_array_equal(view.motion.velocity, before)


def test_what_is_right_passes(tmp_path: Path, view: EffectInputs) -> None:
    path = tmp_path / "mine.py"
    path.write_text(HEAD + ADDITIVE.format(body="return view.motion.position[..., None] ** 3"))
    effect = from_file(path)
    assert isinstance(effect, Additive)
    np.testing.assert_array_equal(effect.columns(view, {})[..., 0], view.motion.position**3)


def test_a_report_keeps_its_shape(tmp_path: Path, view: EffectInputs) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        HEAD
        + """
effect = Signal(
    **TEXT,
    parameters=(Quantity(name="a", unit="1", meaning="it", starts=(0.1,)),),
    report=lambda torque, view, values: torque[:-1],
)
"""
    )
    effect = from_file(path)
    assert isinstance(effect, Signal)
    assert effect.report
    with pytest.raises(BadInput, match="an array of real numbers"):
        effect.report(np.zeros((5, 3)), view, {})


def test_a_file_that_ends_the_program_is_an_error(tmp_path: Path) -> None:
    path = tmp_path / "mine.py"
    path.write_text("import sys\nsys.exit(0)\n")
    with pytest.raises(BadInput, match=r"mine\.py: SystemExit 0"):
        from_file(path)
