"""Errors in an effect file of the user name the file."""

from pathlib import Path

import numpy as np
import pytest

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import Additive, Signal
from ident.dynamics.effects.user_files import from_file
from recordings.errors import BadInput
from tests.ident.dynamics.given import effect_inputs

HEAD = """
import sys
import numpy as np
from ident.dynamics.effects.base import Additive, Quantity, Signal

TEXT = dict(sentence="It rubs.", symptom="A bump.", causes="dirt", remedy="clean it", equation="a", axis="position")
"""
ADDITIVE = """
def columns(inputs, shapes):
    {body}

effect = Additive(**TEXT, parameters=(Quantity(name="a", unit="1", meaning="it"),), columns=columns)
"""


@pytest.fixture(scope="module")
def inputs() -> EffectInputs:
    return effect_inputs(1)


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("return 1 / 0", "columns: ZeroDivisionError division by zero; mend the file"),
        ("sys.exit(0)", "SystemExit 0"),
        ("return columns(inputs, shapes)", "RecursionError"),
        ("return 'x'", "an array of real numbers .* expected, str found"),
        ("return inputs.motion.position", "expected, float64 .* found"),
        ("return 1j * inputs.motion.position[..., None]", "complex128"),
        ("return np.full((*inputs.motion.position.shape, 1), np.nan)", "finite numbers where the motion is known"),
        ("inputs.motion.velocity[...] *= 0.5", "read-only"),
        ("raise ValueError('two' + chr(10) + 'lines')", "ValueError two lines; mend"),
    ],
)
def test_an_error_names_file_and_function(tmp_path: Path, inputs: EffectInputs, body: str, expected: str) -> None:
    path = tmp_path / "mine.py"
    path.write_text(HEAD + ADDITIVE.format(body=body))
    effect = from_file(path)
    assert isinstance(effect, Additive)
    before = inputs.motion.velocity.copy()
    with pytest.raises(BadInput, match=rf"effect file .*mine\.py: .*{expected}"):
        effect.columns(inputs, {})
    np.testing.assert_array_equal(inputs.motion.velocity, before)


def test_a_report_of_another_shape_is_refused(tmp_path: Path, inputs: EffectInputs) -> None:
    path = tmp_path / "mine.py"
    path.write_text(
        HEAD
        + """
effect = Signal(
    **TEXT,
    parameters=(Quantity(name="a", unit="1", meaning="it", initial_guesses=(0.1,)),),
    report=lambda torque, inputs, values: torque[:-1],
)
"""
    )
    effect = from_file(path)
    assert isinstance(effect, Signal)
    assert effect.report
    with pytest.raises(BadInput, match="an array of real numbers"):
        effect.report(np.zeros((5, 3)), inputs, {})
