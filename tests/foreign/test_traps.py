"""Traps: what no effect of the library is must not be believed to be one."""

from pathlib import Path

import numpy as np
import pytest

from benchmarks.hidden_effects.traps import diagnose_trap, false_names
from recordings.reader import read
from tests.foreign import traps
from tests.foreign.pairs import TRAIN, VALIDATE

SEEDS = (2, 3)
"""One with a held-out recording and one without; the benchmark has more."""


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("kind", traps.KINDS)
def test_trap_is_not_believed(kind: traps.Kind, seed: int) -> None:
    assert false_names(diagnose_trap(kind, seed)) == []


@pytest.mark.parametrize("kind", ["undeclared_weight", "sublinear_friction"])
def test_trap_leaves_structure_that_is_called_unknown(kind: traps.Kind) -> None:
    assert diagnose_trap(kind, 3).verdict == "unknown-structure"


@pytest.mark.parametrize(("seed", "files"), [(2, {TRAIN, VALIDATE}), (3, {TRAIN})])
def test_every_second_trap_has_a_held_out_recording(tmp_path: Path, seed: int, files: set[str]) -> None:
    setting = traps.make(tmp_path, "rising_speed", seed)
    assert {path.name for path in tmp_path.iterdir()} == files
    assert setting.held_out == (VALIDATE in files)


def speed(folder: Path, kind: traps.Kind) -> np.ndarray:
    traps.make(folder, kind, 3)
    recording = read(folder / TRAIN)
    coarse = slice(None, None, round(recording.rig.rate / 25))
    return np.gradient(recording.position[coarse, 0], recording.time[coarse])


def test_speed_rises_with_time(tmp_path: Path) -> None:
    first, second = np.array_split(np.abs(speed(tmp_path, "rising_speed")), 2)
    assert second.max() > 1.5 * first.max()


def test_single_stroke_does_not_return(tmp_path: Path) -> None:
    v = speed(tmp_path, "single_stroke")
    assert v.min() > -0.05 * v.max()


def test_single_speed_is_kept_most_of_the_time(tmp_path: Path) -> None:
    v = np.abs(speed(tmp_path, "single_speed"))
    near = np.abs(v / np.median(v) - 1) < 0.2
    assert near.mean() > 0.6
