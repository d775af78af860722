"""An effect says whether it remembers: then alone the order of the instants matters."""

import numpy as np
import pytest

from ident.dynamics.effects.library import library
from recordings.rig import Axis
from tests.ident.export.models import model_with

LIBRARY = library()
ROWS = 60
TIME = np.arange(ROWS) / 200


@pytest.mark.parametrize("name", LIBRARY)
def test_the_order_of_the_rows_matters_to_effects_with_a_memory_alone(name: str) -> None:
    model = model_with([name], () if "delta" in LIBRARY[name].mechanisms else [Axis()] * 3)
    q = 0.2 * np.sin(25 * TIME[:, None] + np.arange(3))
    given = (q, 5.0 * np.cos(25 * TIME[:, None] + np.arange(3)), -625 * q)
    order = np.random.default_rng(0).permutation(ROWS)
    warm = np.full_like(q, 40.0)
    for compute in (model.torque, model.voltage):
        straight = compute(*given, TIME[1], TIME, warm)[order]
        shuffled = compute(*(signal[order] for signal in given), TIME[1], TIME[order], warm)
        known = np.isfinite(straight) & np.isfinite(shuffled)
        same = known.any() and np.allclose(straight[known], shuffled[known], rtol=1e-9)
        if not same:
            break
    assert same != LIBRARY[name].memory
    assert model.stepped == ((name,) if LIBRARY[name].memory else ())
