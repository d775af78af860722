"""What a recording holds: facts, excerpts, quantization, following errors; and which recordings go together."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ident.data.compatibility import check_no_overlap
from ident.data.excerpts import COUNT, MAX_DURATION, excerpts
from ident.data.following_error import following
from ident.data.prepared_recording import PreparedRecording
from ident.data.quantization import drive_errors, with_encoder_errors
from ident.data.recording_facts import recording_facts
from recordings.errors import BadInput
from recordings.reader import read
from recordings.recording import Floats, Recording
from tests.ident import building


def test_even_samples_of_a_motion_with_reversals() -> None:
    facts = recording_facts([building.prepared(building.record(2, noise=0.01, encoder_step=1e-4))])
    assert (facts.rate_hz, facts.cycles) == (building.RATE, 4)
    assert facts.jitter < 1e-9
    assert facts.duration_s == pytest.approx(16, abs=0.1)
    for joint in facts.joints:
        assert joint.encoder_step == pytest.approx(1e-4)
        assert joint.speed_spread > 0.2
        assert 0.3 < joint.rarer_direction <= 0.5
        assert joint.torque_spread > 0.9
        assert (joint.position_unit, joint.effort_unit) == ("rad", "N m")


def test_jitter_is_that_of_the_stamps() -> None:
    exact = building.record()
    jittered = exact.time + np.random.default_rng(0).normal(0, 0.02 / building.RATE, len(exact.time))
    prepared = replace(building.prepared(exact), recording=replace(exact, time=jittered))
    assert recording_facts([prepared]).jitter == pytest.approx(0.02 * np.sqrt(2), rel=0.1)


def test_several_recordings_count_together() -> None:
    one_way = recording_facts([building.prepared(building.record(drift=20.0))]).joints[0]
    assert (one_way.forward_share, one_way.rarer_direction) == (1, 0)
    narrow, wide = (building.prepared(building.record(size=size)) for size in (0.5, 1.0))
    together = recording_facts([narrow, wide])
    assert together.duration_s == pytest.approx(2 * recording_facts([narrow]).duration_s)
    assert together.joints[0].travel == pytest.approx(recording_facts([wide]).joints[0].travel)


def test_long_recordings_are_cut_into_excerpts_of_whole_cycles(make: Callable[..., Recording]) -> None:
    short = make(cycles=2, rate=100.0)
    (whole,) = excerpts(short)
    assert (whole.recording, whole.start) == (short, 0)
    recording = make(cycles=60, rate=50.0)
    sections = excerpts(recording)
    assert len(sections) == COUNT
    for excerpt in sections:
        part, first = excerpt.recording, int(np.searchsorted(recording.time, excerpt.start))
        assert part.time[0] == 0
        assert len(np.unique(part.repeat[part.repeat >= 0])) >= 2
        np.testing.assert_array_equal(part.position, recording.position[first : first + len(part.time)])
    assert sections[0].start < 20
    assert sections[-1].start > recording.time[-1] - 60
    assert sum(excerpt.recording.time[-1] for excerpt in sections) < 2 * MAX_DURATION


def test_excerpts_of_a_recording_that_paused_an_hour_hold_rows(make: Callable[..., Recording]) -> None:
    recording = make(cycles=4, rate=50.0)
    half = len(recording.time) // 2
    paused = replace(recording, time=recording.time + 3600.0 * (np.arange(len(recording.time)) >= half))
    sections = excerpts(paused)
    assert len(sections) == COUNT
    assert all(len(section.recording.time) > 50 for section in sections)
    assert sections[0].start == 0.0
    assert sections[-1].start > 3600.0


def test_a_recording_that_is_the_beginning_of_another_is_refused(make: Callable[..., Recording]) -> None:
    whole, different = make(cycles=2), make("fig5b", cycles=2)
    half = len(whole.time) // 2
    beginning = replace(whole, time=whole.time[:half], position=whole.position[:half], voltage=whole.voltage[:half])
    check_no_overlap([whole, different])
    with pytest.raises(BadInput, match="begin with the same data"):
        check_no_overlap([different, whole, beginning])


SAMPLE = Path(__file__).parents[3] / "recordings" / "samples" / "fig5a.mcap"


def test_following_error_of_a_sample_is_that_of_its_joints() -> None:
    result = following(read(SAMPLE))
    assert (result.rms < result.worst).all()
    assert 1e-4 < result.overall < 0.01
    assert result.platform_rms is not None
    assert result.platform_worst is not None
    # A platform moves about as far as an elbow 0.34 m from its joint.
    assert 0.1 < result.platform_rms / result.overall < 1.0
    assert result.platform_rms < result.platform_worst


def test_recording_without_repetitions_is_refused() -> None:
    recording = read(SAMPLE)
    with pytest.raises(BadInput, match=r"fig5a\.mcap: targets and positions"):
        following(replace(recording, repeat=np.full_like(recording.repeat, -1)))


STEP = 0.2
"""Of the measured torque [N m]."""


def _prepared(noise: float, step: float = STEP) -> tuple[PreparedRecording, Floats]:
    """A recording whose torque was read in steps, and the torque before noise and steps (n, dof) [N m]."""
    exact = building.record(cycles=4, drift=0.0)
    assert exact.effort is not None
    noisy = exact.effort + noise * np.random.default_rng(0).normal(size=exact.effort.shape)
    read = step * np.rint(noisy / step) if step else noisy
    return building.prepared(replace(exact, effort=read)), exact.effort


def test_encoder_errors_are_at_most_half_a_step_and_differ_between_draws() -> None:
    prepared = building.prepared(building.record(encoder_step=1e-4))
    first, second = (with_encoder_errors(prepared, draw).samples.position for draw in (0, 1))
    assert 0 < np.abs(first - prepared.samples.position).max() <= 0.5e-4 * (1 + 1e-6)
    assert not np.array_equal(first, second)


def test_drive_errors_have_the_size_of_the_real_ones_and_repeat_without_noise() -> None:
    prepared, torque = _prepared(noise=0.0)
    pairs = np.array(drive_errors(prepared, torque))
    assert np.nanstd(pairs[:, 0]) == pytest.approx(np.nanstd(prepared.torque - prepared.condition(torque)), rel=0.25)
    assert np.nanmean(pairs[:, 0] * pairs[:, 1]) > 0.5 * np.nanmean(pairs**2)


@pytest.mark.parametrize(("noise", "step"), [(STEP, STEP), (0.05, 0.0)])
def test_noise_above_the_steps_leaves_nothing_that_repeats(noise: float, step: float) -> None:
    prepared, torque = _prepared(noise, step)
    assert not np.array(drive_errors(prepared, torque)).any()
