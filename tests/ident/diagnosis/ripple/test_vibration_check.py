"""Ripple over the angle against a vibration of fixed frequency."""

import numpy as np
import pytest

from ident.diagnosis.ripple.vibration_check import VIBRATION, with_vibration_alternatives
from ident.diagnosis.search.search import Search
from ident.dynamics.effects.library import library
from tests.ident import building


@pytest.mark.parametrize(("size", "drift", "uncertain"), [(1.0, 0.0, False), (5e-5, 2.0, True)])
def test_only_one_speed_leaves_ripple_and_vibration_apart(size: float, drift: float, uncertain: bool) -> None:
    recording = building.record(
        noise=0.05, extra=lambda motion: 0.4 * np.sin(20.0 * motion.position), size=size, drift=drift
    )
    data = building.split([recording])
    selector = Search(data, {"cogging": library()["cogging"]}, lambda text: None)
    model = building.structure(recording)
    selection = with_vibration_alternatives(selector.select(model, building.start(model)))
    (finding, *_) = selection.findings
    assert (VIBRATION in finding.alternatives) is uncertain
