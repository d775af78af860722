"""The split of recordings into training rows and test rows."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.signal import convolve2d

from ident.diagnosis.split import train_test_split
from ident.diagnosis.split.split_data import MAX_STANDSTILL
from recordings.errors import BadInput
from tests.ident import building


@pytest.mark.parametrize("validate", [False, True])
def test_all_rows_are_the_scored_ones_and_those_near_standstill(validate: bool) -> None:
    recordings = [building.record(cycles=3, encoder_step=1e-3, shape=shape) for shape in range(2)]
    split = building.split(recordings[:1], recordings[1:]) if validate else building.split(recordings)
    pairs = [*zip(split.train, split.train_all, strict=True), *zip(split.test, split.test_all, strict=True)]
    assert all(everything[rows].all() for rows, everything in pairs)
    assert sum(int(everything.sum() - rows.sum()) for rows, everything in pairs) > 0
    assert not any((train & test).any() for train, test in zip(split.train_all, split.test_all, strict=True))


def test_creeping_is_standstill_and_a_reversal_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    time = np.arange(0.0, 4.0, 1 / 500)
    reverses, touches = np.sin(2 * np.pi * time), 1 + np.cos(np.pi * time)  # the latter at 1 s and 3 s
    taps = np.full((17, 1), 1 / 17)
    recording: Any = SimpleNamespace(
        as_recorded=SimpleNamespace(motion=SimpleNamespace(velocity=np.stack([reverses, touches], axis=1))),
        condition=lambda x: convolve2d(x, taps, "same"),
    )
    monkeypatch.setattr(train_test_split, "with_encoder_errors", lambda recording: recording)
    still = train_test_split.standstill_share(recording) > MAX_STANDSTILL
    assert not still[:, 0].any()
    around = np.abs(time % 2 - 1)
    assert still[around < 0.05, 1].all()
    assert not still[around > 0.1, 1].any()


def test_joint_that_hardly_moves_is_refused() -> None:
    short = building.record(2)
    short.position[20:, 1] = short.position[20, 1]
    with pytest.raises(BadInput, match=r"at least 6 held-out samples of every joint .* \d of joint 2"):
        building.split([building.record(2)], [short])


def test_joint_without_torque_in_motion_is_refused() -> None:
    recording = building.record(2)
    assert recording.effort is not None
    recording.effort[10:, 1] = 0.0
    with pytest.raises(BadInput, match="that of joint 2 is 0 wherever it moves"):
        building.split([recording])
