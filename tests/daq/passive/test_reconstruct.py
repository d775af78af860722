"""Samples reconstructed from frames, compared with the recording that holds the frames."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from daq.passive.reconstruct import Motion, Reconstructed, _repeat, reconstruct
from recordings.reader import read
from recordings.recording import CanFrames, Ints, Recording
from recordings.rig import Rig
from recordings.writer import RecordingWriter
from tests.daq.passive.listening import SAMPLE, START, arrivals, sample_frames, write
from trajectories import load

PERIOD = 4e6
Heard = Callable[..., Any]
ONE_COUNT = 2 * np.pi / (8192 * 21)


@pytest.fixture(scope="module")
def sample() -> Recording:
    return read(SAMPLE)


@pytest.fixture(scope="module")
def frames() -> CanFrames:
    return sample_frames()


@pytest.fixture(scope="module")
def motion(sample: Recording) -> Motion:
    return lambda cycles: load("fig5a", sample.rig, 2)


@pytest.fixture
def heard(tmp_path: Path, sample: Recording, frames: CanFrames) -> Heard:
    """Reconstruct the samples from the frames as they were heard, with an arrival [ns] and some of them lost."""

    def reconstructed(
        log: Ints | None = None,
        keep: np.ndarray | None = None,
        motion: Motion | None = None,
        heard_frames: CanFrames = frames,
    ) -> Reconstructed | None:
        path = tmp_path / "r.mcap"
        path.unlink(missing_ok=True)
        write(path, sample.rig, heard_frames, arrivals(frames, PERIOD, 0) if log is None else log, keep)
        return reconstruct(path, sample.rig, motion)

    return reconstructed


def test_same_clock_reproduces_the_recorded_arrays(sample: Recording, motion: Motion, heard: Heard) -> None:
    reconstructed = heard(motion=motion)
    samples = reconstructed.samples
    np.testing.assert_array_equal(samples.stamp - samples.stamp[0], np.arange(len(sample.time)) * 4_000_000)
    np.testing.assert_allclose(samples.position, sample.position, rtol=0, atol=1e-15)
    for name in ("voltage", "statusword", "error_code", "repeat"):
        np.testing.assert_array_equal(getattr(samples, name), getattr(sample, name), err_msg=name)
    known = np.isfinite(sample.command)
    assert np.abs(samples.command - sample.command)[known].max() <= 0.51 * ONE_COUNT
    assert (reconstructed.rate, reconstructed.other_rate(), reconstructed.missing) == (250.0, None, 0)
    assert reconstructed.figures()["stamps"] == "SYNC index x configured period"
    assert (reconstructed.period, reconstructed.cycles, reconstructed.simulated) == (4.0, 2, True)
    assert (reconstructed.trajectory.name, reconstructed.trajectory.cycles) == ("fig5a", 2)


def test_commands_with_torque_offsets_are_found(frames: CanFrames, motion: Motion, heard: Heard) -> None:
    commands = np.isin(frames.id, (0x201, 0x202, 0x203))
    longer = replace(frames, dlc=np.where(commands, 8, frames.dlc))
    assert heard(motion=motion, heard_frames=longer).trajectory


def test_different_clock_changes_the_estimated_period(frames: CanFrames, heard: Heard) -> None:
    reconstructed = heard(arrivals(frames, PERIOD * 1.0003, 0))
    assert reconstructed.figures()["stamps"] == "line through the arrivals"
    assert reconstructed.other_rate() is None, "clocks of two computers"
    assert reconstructed.rate == pytest.approx(250 / 1.0003, rel=1e-6)
    assert np.ptp(np.diff(reconstructed.samples.stamp)) <= 1
    assert reconstructed.period == pytest.approx(4.0012, rel=1e-6)


def test_another_rate_than_that_of_the_rig_file_is_told(frames: CanFrames, heard: Heard) -> None:
    told = heard(arrivals(frames, 2 * PERIOD, 0)).other_rate()
    assert told is not None
    assert told.startswith("250 SYNCs per second expected, as `rate` of the rig file says, 125 found;")


def test_lost_answers_and_syncs_are_gaps(sample: Recording, frames: CanFrames, motion: Motion, heard: Heard) -> None:
    cycle = np.cumsum(frames.id == 0x80) - 1
    keep = ((frames.id != 0x182) | (cycle != 900)) & ((cycle < 1500) | (cycle > 1504))
    reconstructed = heard(arrivals(frames, PERIOD, 1), keep, motion)
    lost = np.zeros(sample.position.shape, bool)
    lost[900, 1] = lost[1500:1505] = True
    np.testing.assert_array_equal(np.isnan(reconstructed.samples.position), lost)
    np.testing.assert_array_equal(np.isnan(reconstructed.samples.voltage), lost)
    np.testing.assert_array_equal(reconstructed.samples.statusword == 0, lost | (sample.statusword == 0))
    np.testing.assert_array_equal(reconstructed.samples.repeat, sample.repeat)
    assert reconstructed.missing == 5
    assert reconstructed.figures()["answers_lost"] == [5, 6, 5]
    assert reconstructed.loss() is None


@pytest.mark.parametrize(
    ("lost", "said"),
    [
        (lambda frames, cycle: (frames.id > 0x180) & (frames.id < 0x184) & (cycle < 100), None),
        (lambda frames, cycle: (frames.id == 0x182) & (cycle % 10 == 5), "their SYNCs were heard: check the cable"),
        (lambda frames, cycle: (frames.id > 0x180) & (frames.id < 0x184), "(100.0%); their SYNCs were heard"),
        (lambda frames, cycle: (cycle >= 1500) & (cycle < 1540), "40 SYNCs are missing, too: close other programs"),
    ],
)
def test_many_missing_answers_are_told_with_the_likely_cause(
    lost: Callable[[CanFrames, Ints], np.ndarray], said: str | None, frames: CanFrames, heard: Heard
) -> None:
    told = heard(keep=~lost(frames, np.cumsum(frames.id == 0x80) - 1)).loss()
    assert told is None if said is None else said in told


def test_long_pause_is_not_counted_as_missing_syncs(sample: Recording, frames: CanFrames, heard: Heard) -> None:
    pause = 10 * 10**9 * (np.cumsum(frames.id == 0x80) > 1000)
    reconstructed = heard(arrivals(frames, PERIOD, 0) + pause)
    assert reconstructed.missing == 0
    stamp = reconstructed.samples.stamp
    assert len(stamp) == len(sample.time)
    assert np.diff(stamp).max() == pytest.approx(10 * 10**9 + PERIOD, abs=10)


@pytest.mark.parametrize("given", [None, "fig5b"])
def test_repetitions_are_detected_without_a_trajectory(given: str | None, sample: Recording, heard: Heard) -> None:
    reconstructed = heard(motion=partial(load, given, sample.rig) if given else None)
    assert reconstructed.trajectory is None
    assert (reconstructed.period, reconstructed.cycles) == (4.0, 2)
    # The commands determine the beginning of the repetitions to within a few counts.
    assert abs(int(np.argmax(reconstructed.samples.repeat == 0)) - int(np.argmax(sample.repeat == 0))) < 15


def test_motion_without_repetition_is_one_repetition_while_enabled(
    sample: Recording, frames: CanFrames, heard: Heard
) -> None:
    reconstructed = heard(keep=np.cumsum(frames.id == 0x80) < 1400)
    enabled = (sample.statusword[:1399] & 0x6F == 0x27).all(axis=1)
    assert 1000 < enabled.sum() < 1399
    np.testing.assert_array_equal(reconstructed.samples.repeat, np.where(enabled, 0, -1))
    assert (reconstructed.period, reconstructed.cycles) == (0.0, 1)


def test_frames_without_sync_give_no_samples(frames: CanFrames, heard: Heard) -> None:
    assert heard(keep=frames.id != 0x80) is None


def one_axis(path: Path, **keys: Any) -> tuple[Rig, RecordingWriter]:
    drive = {"node_id": 5, **keys}
    text = {"name": "one", "mechanism": "axes", "axes": [{}], "rate": 500.0, "drives": [drive]}
    rig = Rig.model_validate(text, strict=False)
    return rig, RecordingWriter(path, rig, read(SAMPLE).run)


def test_torque_and_emergency_codes_are_reconstructed(tmp_path: Path) -> None:
    keys = {"torque_actual": True, "sign": -1, "rated_torque": 10.0, "zero_offset": 0.5}
    rig, opened = one_axis(tmp_path / "r.mcap", **keys)
    with opened as writer:

        def hear(time: int, arbitration_id: int, data: bytes) -> None:
            writer.can(START + time, START + time, arbitration_id, data, sent=False)

        for k in range(6):
            now = k * 2_000_000
            if k == 3:
                hear(now - 500_000, 0x85, bytes.fromhex("1032000000000000"))
            hear(now, 0x80, b"")
            hear(now + 1000, 0x185, bytes.fromhex("3712e803000064ff"))
            hear(now + 2000, 0x285, bytes.fromhex("f401"))
            hear(now + 3000, 0x185, b"short")
    reconstructed = reconstruct(tmp_path / "r.mcap", rig)
    assert reconstructed is not None
    samples = reconstructed.samples
    counts = 8192 * 21 / (2 * np.pi)
    np.testing.assert_allclose(samples.position, np.full((6, 1), 0.5 - 1000 / counts))
    np.testing.assert_allclose(samples.voltage, np.full((6, 1), 156 * 0.0005))
    np.testing.assert_allclose(samples.effort, np.full((6, 1), -0.5 * 10.0))
    # The frame came before the fourth SYNC, so it belongs to the third cycle.
    assert samples.error_code[:, 0].tolist() == [0, 0, 0x3210, 0x3210, 0x3210, 0x3210]
    assert not reconstructed.simulated
    assert np.isnan(samples.command).all()


def test_voltage_of_32_bits_is_known_by_the_length_of_its_frames(tmp_path: Path) -> None:
    rig, opened = one_axis(tmp_path / "r.mcap", voltage={"index": 0x2030, "sub": 0, "scale": 0.001})
    with opened as writer:
        for k in range(6):
            now = START + k * 2_000_000
            writer.can(now, now, 0x80, b"", sent=False)
            writer.can(now + 1000, now + 1000, 0x185, bytes.fromhex("3712e8030000"), sent=False)
            writer.can(now + 2000, now + 2000, 0x285, (70_000).to_bytes(4, "little"), sent=False)
    reconstructed = reconstruct(tmp_path / "r.mcap", rig)
    assert reconstructed is not None
    np.testing.assert_allclose(reconstructed.samples.voltage, np.full((6, 1), 70.0))


def test_the_number_of_cycles_is_that_of_the_commands(sample: Recording) -> None:
    for cycles in (1, 3):
        commanded = load("fig5b", sample.rig, cycles).joint_position
        rest = np.zeros((100, 1), np.int64)
        command = commanded[np.vstack([rest, np.arange(len(commanded))[:, None]])[:, 0]]
        joints = {"command": command, "position": command}
        repeat, period, found = _repeat(sample.rig, joints, partial(load, "fig5b", sample.rig))
        assert found is not None
        assert (found.cycles, repeat.max() + 1, period) == (cycles, cycles, 3.0 * sample.rig.rate)


def test_syncs_of_a_lockstep_tell_no_time(
    tmp_path: Path, sample: Recording, frames: CanFrames, motion: Motion, heard: Heard
) -> None:
    """Each waits for the answers to the one before, on a busy computer for long."""
    waits = np.random.default_rng(0).exponential(3.0, np.count_nonzero(frames.id == 0x80))
    waits[1000] = 50.0
    log = arrivals(frames, PERIOD, 0) + np.rint(PERIOD * np.cumsum(waits)[np.cumsum(frames.id == 0x80) - 1]).astype(
        int
    )
    assert heard(log).other_rate().endswith("are recorded with --pace lockstep")
    made = reconstruct(tmp_path / "r.mcap", sample.rig, motion, lockstep=True)
    assert made is not None
    assert (made.rate, made.missing, made.other_rate(), made.loss()) == (250.0, 0, None, None)
    np.testing.assert_allclose(made.samples.position, sample.position, rtol=0, atol=1e-15)
    assert made.trajectory is not None
