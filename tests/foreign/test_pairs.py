"""Recordings of the second plant."""

from pathlib import Path

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


def test_motion_without_repetition_has_no_cycles(tmp_path: Path) -> None:
    make(tmp_path, [], [], 1, Setting(rate=100.0, repeats=False))
    for name in ("train.mcap", "validate.mcap"):
        assert read(tmp_path / name).repeat.max() == -1


def test_impossible_size_is_refused(tmp_path: Path) -> None:
    with pytest.raises(BadInput, match="choose another"):
        make(tmp_path, ["amplifier_deadband"], [0.03], 1, Setting(reports_command=False))
