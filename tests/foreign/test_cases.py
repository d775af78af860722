"""Cases of the benchmark that need one idea of the search."""

from pathlib import Path

import pytest

from benchmarks.hidden_effects.diagnosing import diagnose
from benchmarks.hidden_effects.parts import cases
from benchmarks.hidden_effects.recording import record


@pytest.mark.slow
def test_curve_takes_the_place_of_what_imitates_it_together(tmp_path: Path) -> None:
    """A spring, a shifted centre of mass and slow ripple of all joints; a curve contains the first two alone."""
    (case,) = (each for each in cases("foreign", "chosen") if each.name.endswith("position_torque-3%-16"))
    record(case, tmp_path)
    document = diagnose(case, tmp_path, "")["document"]
    assert [finding["effect"] for finding in document["findings"]] == ["rod_inertia", "position_torque"]
