"""Tables printed about a designed motion."""

import io

import numpy as np
from rich.console import Console

from ident.design.quality import Quality
from ident.output.console import design


def test_shares_have_no_exponent() -> None:
    shares = {"stribeck": 0.0123, "base_tilt": 0.996, "backlash": 1.84, "cogging": 188.5}
    after = Quality(condition=1.0, std=np.array([]), discriminability=shares, usage={})
    outcome = design.DesignResult("next.toml", "d", 0, 0.1, 10.0, (), after, None, None)
    screen = io.StringIO()
    design.show(outcome, Console(file=screen, width=120))
    for expected in ("1.2 %", "100 %", "184 %", "18,850 %"):
        assert f" {expected}" in screen.getvalue()
    assert "e+" not in screen.getvalue()
