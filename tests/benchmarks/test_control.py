from pathlib import Path

import numpy as np
import pytest

from benchmarks.control import CASES, SERVO, ClosedLoop, show
from drivers.simulated.config import load_sim
from drivers.simulated.effect import discover
from ident.data.following_error import Following


def _run(rms: float) -> Following:
    return Following(np.full(3, rms), np.full(3, 3 * rms), rms, 3 * rms)


def test_each_case_is_a_sim_file_with_the_effect_of_its_name(tmp_path: Path) -> None:
    for name, text in CASES.items():
        (tmp_path / "sim.toml").write_text(SERVO + text)
        (effect,) = load_sim(tmp_path / "sim.toml").effects
        assert effect.name == name
        assert name in discover()


def test_verdict_of_a_case(capsys: pytest.CaptureFixture[str]) -> None:
    case = ClosedLoop("cogging", ("cogging",), tuple(map(_run, (4.0, 3.0, 2.0, 1.0))))
    assert case.falls
    assert case.ratio == 0.5
    assert not ClosedLoop("cogging", (), tuple(map(_run, (4.0, 3.0, 1.0, 2.0)))).falls
    show([case])
    assert "falls at every step; with the effect 50% of the base model's" in capsys.readouterr().out
