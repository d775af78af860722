"""Identification from listened recordings, whose time stamps are estimated from arrival times."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from daq.passive import listen
from daq.passive.reconstruct import reconstruct
from daq.simulation import torque_age
from recordings import blocks
from recordings.reader import read
from recordings.recording import CanFrames, Ints
from recordings.recovery import rewrite
from tests.conftest import Runner
from tests.daq.passive.listening import SAMPLE, START, sample_frames, write
from trajectories import load

JITTER = 100e3
"""Standard deviation of every arrival [ns]."""
OUTLIERS = 0.002
"""Share of the frames that are late by several milliseconds and delay all later frames."""


def jittered(frames: CanFrames, period: float, seed: int) -> Ints:
    """Arrival time of each frame (n,) [ns]; the bus keeps their order."""
    rng = np.random.default_rng(seed)
    cycle = np.cumsum(frames.id == 0x80)
    order = np.minimum(np.arange(len(cycle)) - np.searchsorted(cycle, cycle), 40)
    late = rng.normal(0, JITTER, len(cycle)) + rng.uniform(2e6, 8e6, len(cycle)) * (rng.random(len(cycle)) < OUTLIERS)
    arrival: Ints = np.maximum.accumulate(np.rint(cycle * period + 20e3 * order + late).astype(np.int64))
    return START + arrival


def fitted(ident: Runner, file: Path) -> dict[str, float]:
    # The bare model: m_d beside it is determined less well than the recordings differ.
    done = ident("fit", file, "--method", "ls", "--without", "rod_inertia")
    assert done.code == 0, done.err
    parameters = json.loads(file.with_suffix(".model.json").read_text())["parameters"]
    return {parameter["name"]: parameter["value"] for parameter in parameters}


def worst(estimate: dict[str, float], expected: dict[str, float]) -> float:
    """Largest relative difference of the parameters."""
    return max(abs(estimate[name] / value - 1) for name, value in expected.items())


@pytest.mark.slow
def test_arrival_jitter_does_not_affect_the_fitted_parameters(ident: Runner, tmp_path: Path) -> None:
    sample, frames = read(SAMPLE), sample_frames()
    original = tmp_path / "original.mcap"
    age = torque_age(sample.rig.rate)
    rewrite(SAMPLE, original, {"torque_age": str(age)})  # the sample was recorded before runs said so
    expected = fitted(ident, original)
    trajectory = load("fig5a", sample.rig, 2)
    end = {"exit_status": "0", "reason": "enough"}
    for name, clock in (("ours", 1.0), ("another", 1 + 1e-4)):
        file = tmp_path / f"{name}.mcap"
        write(file, sample.rig, frames, jittered(frames, 4e6 * clock, seed=1))
        estimate = listen.complete(file, sample.rig, trajectory, end)
        assert estimate.uses_configured_period == (name == "ours")
        assert estimate.rate == pytest.approx(250 / clock, rel=5e-6)
        assert read(file).run.torque_age == age, "known by the name of the drives"
        # With the other clock, everything really is slower by 1e-4.
        assert worst(fitted(ident, file), expected) < 1e-3
    assert _worst_by_arrivals(ident, tmp_path, expected) > 5e-3


def _worst_by_arrivals(ident: Runner, folder: Path, expected: dict[str, float]) -> float:
    """Compute the same with the arrival times as time stamps, to show the benefit of the line fit."""
    recording, file = read(folder / "ours.mcap"), folder / "arrivals.mcap"
    estimate = reconstruct(folder / "ours.mcap", recording.rig, load("fig5a", recording.rig, 2))
    assert estimate is not None
    rng, n = np.random.default_rng(2), len(estimate.samples.stamp)
    late = rng.normal(0, JITTER, n) + rng.uniform(0.5e6, 2e6, n) * (rng.random(n) < OUTLIERS)
    stamp = estimate.samples.stamp + np.rint(late).astype(np.int64)
    blocks.write(file, recording.rig, recording.run, replace(estimate.samples, stamp=stamp))
    return worst(fitted(ident, file), expected)
