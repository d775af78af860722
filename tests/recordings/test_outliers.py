"""Single samples far outside of all others, and what only looks like them."""

from pathlib import Path

import numpy as np
import pytest

from recordings.outliers import outliers
from recordings.reader import read

SAMPLES = Path(__file__).parents[2] / "recordings" / "samples"
TIME = np.arange(5000) / 500
TORQUE = 10 * np.sin(2 * np.pi * 0.7 * TIME)
RNG = np.random.default_rng(3)


@pytest.mark.parametrize("noise", [0.0, 0.3])
@pytest.mark.parametrize("place", [0, 1, 2500, 4998, 4999])
def test_single_samples_are_marked(place: int, noise: float) -> None:
    values = TORQUE + RNG.normal(scale=noise, size=len(TIME))
    values[place] = -200.0
    values[300:310] = np.nan
    assert np.flatnonzero(outliers(values)).tolist() == [place]


def test_several_of_any_size_are_marked() -> None:
    values = np.rint(TORQUE)
    places = [100, 103, 900, 3000]
    values[places] = 60.0, -60.0, 1e3, 1e6
    assert np.flatnonzero(outliers(values)).tolist() == places


def impacts() -> np.ndarray:
    """Rebounds at both ends of a play, in every cycle."""
    phase = np.arange(len(TIME)) % 250
    return TORQUE + RNG.normal(scale=0.05, size=len(TIME)) + 25 * np.exp(-phase / 2) * np.cos(2 * phase)


def pulses() -> np.ndarray:
    """Torque that is zero but for one stroke."""
    return np.where(np.abs(TIME - 5) < 0.01, 30.0, 0.0)


ORDINARY = {
    "noise": RNG.normal(size=5000),
    "heavy tails": RNG.standard_t(3, size=5000),
    "coarse steps": np.rint(TORQUE / 2) * 2,
    "one step of a converter": np.where(np.arange(5000) == 77, 0.1, 0.0) + np.rint(TORQUE),
    "rare steps of a converter": 3 + np.where(np.arange(5000) % 700 == 77, 0.1, 0.0),
    "impacts": impacts(),
    "a transient without noise": (TIME > 5) * 3 * np.exp(-np.abs(TIME - 5) / 0.002) + 0.01 * TIME,
    "a stroke": pulses(),
    "constant": np.full(5000, 3.0),
    "sign of a velocity": 3 * np.sign(TORQUE),
    "few samples": np.array([0.0, 100.0, 0.0, 1.0]),
    "gaps only": np.full(500, np.nan),
}


@pytest.mark.parametrize("name", ORDINARY)
def test_ordinary_values_are_not_marked(name: str) -> None:
    assert not outliers(ORDINARY[name]).any()


@pytest.mark.parametrize("name", ["fig5a", "fig5b"])
def test_recordings_have_none(name: str) -> None:
    recording = read(SAMPLES / f"{name}.mcap")
    for values in (*recording.position.T, *recording.voltage.T):
        assert not outliers(values).any()
