"""What a diagnosis works with."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from ident.diagnose.material import Material


def test_errors_in_a_regressor_make_a_fit_believe_it_less() -> None:
    rng = np.random.default_rng(0)
    read = rng.normal(size=(20_000, 1, 1))
    other = read + 0.5 * rng.normal(size=read.shape)
    seen = np.ones((len(read), 1), bool)
    of = [SimpleNamespace(linearised=lambda bare, x, columns=columns: (None, columns)) for columns in (read, other)]
    material: Any = Material((of[0],), (seen,), (~seen,), (np.where(seen, 3.0, 0.0),), True)  # type: ignore[arg-type]
    material.__dict__["disturbed"] = (of[1],)
    columns, misled = material.misread(SimpleNamespace(terms=(), named=(None,)))
    assert columns == [(read, other)]
    # -E[other (other - read)] / E[other^2]
    assert misled == pytest.approx(-0.25 / 1.25, rel=0.05)
