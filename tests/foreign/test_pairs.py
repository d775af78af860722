"""Recordings of the second plant."""

from pathlib import Path
from typing import Literal

import numpy as np
import pytest

from recordings.errors import BadInput
from recordings.reader import read
from tests.foreign.pairs import Setting, make


def test_pair_is_two_motions_of_one_robot_with_the_effect_in_the_truth(tmp_path: Path) -> None:
    truth = make(tmp_path, ["cogging"], [0.02], 5, Setting(robot="light", bits=16, rate=250.0))
    (effect,) = truth["effects"]
    assert effect["name"] == "cogging"
    assert effect["size"] == pytest.approx(0.02, rel=0.1)
    train, validate = read(tmp_path / "train.mcap"), read(tmp_path / "validate.mcap")
    assert train.rig == validate.rig
    assert train.run.simulated
    assert train.repeat.max() >= 2
    assert train.run.period != validate.run.period
    step = 2 * np.pi / (round(2**16 / 21) * 21)
    counts = train.position / step
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-3)


def test_seed_determines_the_recording(tmp_path: Path) -> None:
    for folder, seed in (("a", 1), ("b", 1), ("c", 2)):
        (tmp_path / folder).mkdir()
        make(tmp_path / folder, [], [], seed, Setting(rate=250.0))
    a, b, c = (read(tmp_path / folder / "train.mcap") for folder in "abc")
    np.testing.assert_array_equal(a.voltage, b.voltage)
    assert len(a.voltage) != len(c.voltage) or not np.allclose(a.voltage, c.voltage)


def test_voltage_noise_is_that_of_the_setting(tmp_path: Path) -> None:
    make(tmp_path, [], [], 1, Setting(volts=0.03))
    recording = read(tmp_path / "train.mcap")
    cycles = [recording.voltage[recording.repeat == cycle] for cycle in (0, 1)]
    assert np.std(cycles[0] - cycles[1]) / np.sqrt(2) == pytest.approx(0.03, rel=0.05)


def test_motion_without_repetition_has_no_cycles(tmp_path: Path) -> None:
    make(tmp_path, [], [], 1, Setting(rate=100.0, repeats=False))
    for name in ("train.mcap", "validate.mcap"):
        assert read(tmp_path / name).repeat.max() == -1


def test_effort_is_the_torque_of_the_voltage(tmp_path: Path) -> None:
    for folder, setting in (
        ("v", Setting(rate=100.0, volts=0.0)),
        ("e", Setting(rate=100.0, volts=0.0, signal="effort")),
    ):
        (tmp_path / folder).mkdir()
        make(tmp_path / folder, [], [], 1, setting)
    volts, effort = read(tmp_path / "v" / "train.mcap"), read(tmp_path / "e" / "train.mcap")
    assert effort.effort is not None
    assert not np.isfinite(effort.voltage).any()
    gain = np.array(volts.rig.torque.gain)
    np.testing.assert_allclose(effort.effort, gain * volts.voltage * np.abs(volts.voltage), atol=2e-4)


@pytest.mark.parametrize("signal", ["voltage", "effort"])
def test_coarse_signal_has_the_steps_of_its_resolution(tmp_path: Path, signal: Literal["voltage", "effort"]) -> None:
    make(tmp_path, [], [], 1, Setting(rate=100.0, signal=signal, signal_bits=10))
    recording = read(tmp_path / "train.mcap")
    values = np.unique(recording.voltage if recording.effort is None else recording.effort)
    assert 2**8 < len(values) < 2**10


def test_impossible_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="choose another"):
        make(tmp_path, ["amplifier_deadband"], [0.03], 1, Setting(reports_command=False))
