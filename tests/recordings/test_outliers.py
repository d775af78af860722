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


def test_lost_samples_in_a_row_hide_no_single_one() -> None:
    values = np.rint(TORQUE)
    values[[100, 2000, 2001]] = 1e4
    assert np.flatnonzero(outliers(values)).tolist() == [100]


PHASE = np.arange(len(TIME)) % 250
IMPACTS = 25 * np.exp(-PHASE / 2) * np.cos(2 * PHASE)
"""Rebounds at both ends of a play, in every cycle."""
SHORT_IMPACTS = np.where(PHASE == 60, 6.0, 0.0) + np.where(PHASE == 61, 1.5, 0.0)
SHORT_IMPACTS[(TIME > 3.9) & (SHORT_IMPACTS == 1.5)] = 0.0
"""Impacts on a play: the later ones end within one sample."""
ORDINARY = {
    "noise": RNG.normal(size=5000),
    "heavy tails": RNG.standard_t(3, size=5000),
    "coarse steps": np.rint(TORQUE / 2) * 2,
    "one step of a converter": np.where(np.arange(5000) == 77, 0.1, 0.0) + np.rint(TORQUE),
    "rare steps of a converter": 3 + np.where(np.arange(5000) % 700 == 77, 0.1, 0.0),
    "impacts": TORQUE + RNG.normal(scale=0.05, size=5000) + IMPACTS,
    "impacts of one sample": np.sin(TIME) + RNG.normal(scale=0.06, size=5000) + SHORT_IMPACTS,
    "a transient without noise": (TIME > 5) * 3 * np.exp(-np.abs(TIME - 5) / 0.002) + 0.01 * TIME,
    "a stroke": np.where(np.abs(TIME - 5) < 0.01, 30.0, 0.0),
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
