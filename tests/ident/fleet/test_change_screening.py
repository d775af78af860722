"""Only what the later recordings have is a candidate; usual scatter of the parameters is none."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ident.diagnosis.diagnosis import DiagnosisOptions
from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import library
from ident.fleet.change_screening import ChangeScreener, as_change
from ident.fleet.recording_rows import base_fit
from recordings.recording import Floats


@pytest.fixture
def screener(tmp_path: Path, night: Callable[..., Path], truth: Floats) -> Callable[[Floats, float], ChangeScreener]:
    """Of two recordings, of which the later one has other parameters."""

    def screen(change: Floats, scatter: float) -> ChangeScreener:
        paths = [
            night(tmp_path / f"0-{scatter}.mcap", 0),
            night(tmp_path / f"1-{scatter}.mcap", 1, parameters=truth * (1 + change)),
        ]
        inputs, model = base_fit(paths, DiagnosisOptions())
        usual = np.tile(scatter * np.abs(model.solution.x), (2, 1))
        return ChangeScreener(inputs.split, model.solution, [False, True], usual)

    return screen


def test_another_friction_is_named_with_its_joint(screener: Callable[..., ChangeScreener]) -> None:
    change = np.zeros(11)
    change[9] = 0.2  # Coulomb friction of joint 2
    screened = screener(change, 0.0)
    candidates = screened.screen(screened.parameter_effects()).candidates
    assert candidates[0].term.name == "coulomb_friction"
    assert candidates[0].term.joints == (1,)
    assert candidates[0].loss < 0.7 * screened.loss
    loss, rows = screened.loss_before()
    assert candidates[0].loss == pytest.approx(loss / rows * screened.row_count, rel=0.3)
    assert 0 < (screened.loss - candidates[0].loss) / screened.torque_after() < 0.2


def test_usual_scatter_explains_what_is_within_it(screener: Callable[..., ChangeScreener]) -> None:
    change = np.zeros(11)
    change[9] = 0.02
    strict, tolerant = (screener(change, scatter) for scatter in (0.0, 0.05))
    gains = [each.loss - each.screen(each.parameter_effects()).candidates[0].loss for each in (strict, tolerant)]
    assert gains[1] < 0.2 * gains[0]


def test_difference_of_friction_is_added_to_it_and_may_be_negative() -> None:
    effects = library([])
    change = as_change(effects["position_dependent_friction"])
    assert isinstance(change, Additive)
    assert change.replaces is None
    assert {quantity.lower for quantity in change.parameters} == {-np.inf}
    for name in ("stribeck", "torque_gain_mismatch"):
        assert as_change(effects[name]) is effects[name]
