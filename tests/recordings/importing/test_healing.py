"""Spans of time that are kept, or left out."""

import shlex
from pathlib import Path

import numpy as np
import pytest

from daq.commands.import_ import command
from recordings.blocks import SampleTable, write
from recordings.errors import BadInput
from recordings.importing import Description, import_data
from recordings.importing.healing import Healing, TimeSpan
from recordings.reader import read
from recordings.recording import Recording
from tests.running import invoke

SAMPLE = Path("recordings/samples/fig5a.mcap").resolve()


@pytest.fixture(scope="module")
def whole() -> Recording:
    """Return a sample: its first repetition begins after the approach."""
    return read(SAMPLE)


def healed(file: Path, folder: Path, healing: Healing) -> Recording:
    import_data(file, folder / "out.mcap", Description(healing=healing))
    return read(folder / "out.mcap")


def test_trimmed_recording_begins_at_zero_with_whole_repetitions(whole: Recording, tmp_path: Path) -> None:
    start = float(whole.time[np.argmax(whole.repeat == 0)]) + 0.5
    trimmed = healed(SAMPLE, tmp_path, Healing(trim=TimeSpan(start, 1e3)))
    rows = whole.time >= start
    np.testing.assert_array_equal(trimmed.position, whole.position[rows])
    np.testing.assert_allclose(trimmed.time, whole.time[rows] - whole.time[rows][0], atol=1e-9)
    np.testing.assert_array_equal(trimmed.repeat, np.maximum(whole.repeat[rows] - 1, -1))
    assert trimmed.run.cycles == whole.run.cycles - 1


def test_excluded_times_are_gaps_counted_before_the_trim(whole: Recording, tmp_path: Path) -> None:
    changed = healed(SAMPLE, tmp_path, Healing(exclude=(TimeSpan(2, 2.5), TimeSpan(4, 5)), trim=TimeSpan(1, 6)))
    rows = (whole.time >= 1) & (whole.time <= 6)
    time = whole.time[rows]
    gaps = ((time >= 2) & (time <= 2.5)) | ((time >= 4) & (time <= 5))
    for name in ("position", "voltage"):
        expected = np.where(gaps[:, None], np.nan, getattr(whole, name)[rows])
        np.testing.assert_array_equal(getattr(changed, name), expected)
    np.testing.assert_array_equal(changed.command, whole.command[rows])


def test_start_of_a_trimmed_recording_is_later(whole: Recording, tmp_path: Path) -> None:
    stamp, ones = np.arange(100) * 10**8, np.ones((100, 3))
    nowhere = np.full(100, -1)
    samples = SampleTable(whole.rig.joint_names, stamp, stamp, stamp, nowhere, position=ones, voltage=ones)
    run = whole.run.model_copy(update={"start": "2026-01-05T08:00:00.000+00:00"})
    write(tmp_path / "dated.mcap", whole.rig, run, samples)
    trimmed = healed(tmp_path / "dated.mcap", tmp_path, Healing(trim=TimeSpan(2.5, 4)))
    assert trimmed.run.start == "2026-01-05T08:00:02.500+00:00"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ("--trim 5:3", "times such as 2.5:10 expected, '5:3' found"),
        ("--trim 5", "times such as 2.5:10 expected, '5' found"),
        ("--exclude 1:2:3", "times such as 2.5:10 expected"),
        ("--exclude nan:3", "times such as 2.5:10 expected"),
        ("--trim 1:2,3:4", "--trim: one span of time expected, 2 found"),
        ("--trim 500:600", "--trim: some of the times from 0 to"),
        ("--trim 1:1.001", "--trim: some of the times from 0 to"),
        ("--exclude=-1:600", "--exclude: some of the times from 0 to"),
    ],
)
def test_spans_that_cannot_be_are_refused(options: str, message: str, tmp_path: Path) -> None:
    result = invoke(command, SAMPLE, "--out", tmp_path / "out.mcap", *shlex.split(options))
    assert isinstance(result.exception, BadInput)
    assert message in str(result.exception)
    assert not (tmp_path / "out.mcap").exists()
