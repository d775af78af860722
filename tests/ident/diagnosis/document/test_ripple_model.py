"""Models with ripple above the low-pass."""

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import ident
from daq.program import program

RATE, STROKE = 500.0, 0.8


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """Two recordings of an axis whose torque ripples 200 times per turn."""
    folder, result = tmp_path_factory.mktemp("ripple"), []
    for name, hertz, seed in (("a", 0.31, 0), ("b", 0.23, 1)):
        time = np.arange(int(20 * RATE)) / RATE
        omega = 2 * np.pi * hertz
        angle = STROKE * np.sin(omega * time)
        noise = 0.05 * np.random.default_rng(seed).normal(size=len(time))
        speed = STROKE * omega * np.cos(omega * time)
        effort = -0.4 * omega**2 * angle + 0.8 * speed + 0.5 * np.sign(speed) + 0.3 * np.sin(200 * angle) + noise
        table = folder / f"{name}.csv"
        np.savetxt(
            table,
            np.stack([time, angle, effort], axis=1),
            "%.7f",
            ",",
            header="time,position_1,effort_1",
            comments="",
        )
        options = ["--mechanism", "axes", "--joints", "revolute", "--out", str(folder / f"{name}.mcap")]
        assert CliRunner().invoke(program, ["import", str(table), *options]).exit_code == 0
        result.append(folder / f"{name}.mcap")
    return result


def test_applied_model_predicts_the_ripple(files: list[Path], tmp_path: Path) -> None:
    train, validate = files
    diagnosis = ident.diagnose([train], validate=[validate])
    assert "cogging" in [finding.effect for finding in diagnosis.findings]
    fitted = diagnosis.apply()
    assert fitted.file.effects == diagnosis.document.steps[-1].effects
    fitted.save(tmp_path / "m.json")
    model = ident.load_model(tmp_path / "m.json")
    angle = np.linspace(0.1, 0.3, 400)[:, None]
    torque = model.torque(angle, np.ones_like(angle), np.zeros_like(angle))[:, 0]
    assert np.ptp(torque) == pytest.approx(0.6, rel=0.1)
