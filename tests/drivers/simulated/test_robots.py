from pathlib import Path

import numpy as np
import pytest

from drivers.simulated.config import ROBOTS, Friction, load_sim
from recordings.errors import BadInput
from tests.drivers.simulated.swinging import along_fig5a

REPEATED = slice(5000, 25_000)
"""Steps of the repetition, between lead-in and lead-out of a second each."""


@pytest.mark.parametrize(("name", "rms", "low", "high"), [("light", 1.4, 0.2, 0.5), ("heavy", 15.0, -1.0, 1e-9)])
def test_torque_and_its_share_of_negative_values(name: str, rms: float, low: float, high: float) -> None:
    torque = along_fig5a(load_sim(ROBOTS / f"{name}.toml")).motor_torque[REPEATED]
    negative = np.mean(torque < 0, axis=0)
    assert np.all((negative > low) & (negative < high))
    assert np.sqrt(np.mean(torque**2, axis=0)) == pytest.approx([rms] * 3, rel=0.1)


def test_friction_of_eq_36_is_most_of_the_torque_of_the_paper_friction_robot() -> None:
    config = load_sim(ROBOTS / "paper_friction.toml")
    assert config.friction.coulomb == (9.1037, 7.6127, 9.2628)
    without = config.model_copy(update={"friction": Friction(coulomb=(0.0, 0.0, 0.0))})
    difference = (along_fig5a(config).motor_torque - along_fig5a(without).motor_torque)[REPEATED]
    assert np.sqrt(np.mean(difference**2, axis=0)) == pytest.approx(config.friction.coulomb, rel=0.05)


def test_a_shipped_robot_is_found_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert load_sim(Path("heavy")) == load_sim(Path("heavy.toml")) == load_sim(ROBOTS / "heavy.toml")
    Path("heavy").write_text("voltage_noise = 0.5")
    assert load_sim(Path("heavy")).voltage_noise == 0.5
    with pytest.raises(BadInput, match="does not exist"):
        load_sim(Path("elsewhere/light"))
