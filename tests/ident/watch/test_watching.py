"""Watching a recording: the residual is that of compare, a change is named once, and nothing else raises an alarm."""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ident
from ident.basics import slicing
from ident.identification.model import Model
from ident.watch.residual_follower import ResidualFollower
from ident.watch.watching import Watch
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from tests.ident import building

JOINTS, NOISE = 2, 0.1
ONSET = 26.0
"""When the friction of the second joint changes [s]."""


def record(seed: int, cycles: int = 12, **options: Any) -> Recording:
    return building.record(JOINTS, cycles, noise=NOISE, seed=seed, name=f"run{seed}", **options)


def changed(recording: Recording, torque: Floats, since: float = ONSET) -> Recording:
    """The recording with a `torque` (n,) of its second joint from a time on [s]."""
    effort = recording.effort
    effort = effort.copy()
    effort[:, 1] += np.where(recording.time >= since, torque, 0.0)
    return replace(recording, effort=effort)


def friction(recording: Recording, size: float = 0.15) -> Floats:
    return size * np.sign(np.gradient(recording.position[:, 1]))


def pieces(recording: Recording, samples: int = 100) -> Iterator[Recording]:
    for first in range(0, len(recording.time), samples):
        yield slicing.along_time(recording, slice(first, first + samples))


@pytest.fixture(scope="module")
def model() -> Model:
    return ident.fit(record(1, shape=1), method="ls", cutoff=building.CUTOFF)


def watched(model: Model, recording: Recording, *healthy: Recording, **options: Any) -> list[dict[str, Any]]:
    watch = Watch(model, healthy or (record(2),), **options)
    lines = list(watch.lines(pieces(recording)))
    assert watch.alarmed == any(line["alarm"] for line in lines)
    return lines


def test_residual_equals_that_of_compare(model: Model) -> None:
    recording = record(3, 4)
    expected = ident.compare(model, recording).predictions[0]
    follower = ResidualFollower(model)
    seconds = [second for piece in pieces(recording) for second in follower.seconds(piece)]
    seconds += follower.last()
    followed = np.concatenate([second.rows.residual for second in seconds if second.rows is not None])
    assert follower.delay <= 0.25
    rms = [np.sqrt(np.nanmean(residual**2, axis=0)) for residual in (followed, expected.residual)]
    np.testing.assert_allclose(*rms, rtol=0.01)
    assert np.isfinite(followed).sum() == np.isfinite(expected.residual).sum()


def test_each_second_has_a_line_and_health_raises_no_alarm(model: Model) -> None:
    recording = record(3)
    lines = watched(model, recording)
    assert [line["time"] for line in lines[:-1]] == list(range(1, len(lines)))
    assert lines[-1]["time"] == pytest.approx(recording.time[-1], abs=0.01)
    assert not any(line["alarm"] for line in lines)
    assert len({line["delay"] for line in lines}) == 1
    assert np.array([line["residual_rms"] for line in lines]) == pytest.approx(NOISE * np.sqrt(60 / 250), rel=0.3)


def test_change_is_found_and_named_once(model: Model) -> None:
    recording = record(3)
    (alarm,) = (line for line in watched(model, changed(recording, friction(recording))) if line["alarm"])
    found = alarm["alarm"]
    assert ONSET < alarm["time"] < ONSET + 12
    assert found["joints"] == [2]
    assert abs(found["since"] - ONSET) <= building.PERIOD
    assert found["kind"] == "sudden"
    assert "coulomb_friction" in (found["effect"], *found["confusable_with"])
    assert found["evidence"] > 100


def test_what_healthy_recordings_show_too_is_no_change(model: Model) -> None:
    recording, healthy = record(3), record(2)
    slow = friction(recording) * recording.time / recording.time[-1]
    lines = watched(model, changed(recording, slow, 0.0), changed(healthy, slow, 0.0))
    assert not any(line["alarm"] for line in lines)


@pytest.mark.parametrize("left_out", ["temperature", "limit", "place"])
def test_what_healthy_recordings_cannot_tell_counts_for_nothing(model: Model, left_out: str) -> None:
    healthy = replace(record(2), extra={f"temperature_{joint}": np.full(3000 * 4, 30.0) for joint in (1, 2)})
    recording = record(3, shape=2 if left_out == "place" else 0)
    recording = changed(recording, friction(recording))
    late = recording.time >= ONSET
    if left_out == "temperature":
        warm = np.where(late, 45.0, 30.0)
        recording = replace(recording, extra={f"temperature_{joint}": warm for joint in (1, 2)})
    elif left_out == "limit":
        limited = np.where(late[:, None], np.uint16(0x0800), recording.statusword)
        recording = replace(recording, statusword=limited)
    assert not any(line["alarm"] for line in watched(model, recording, healthy))


def test_samples_are_thinned_and_causes_add_up(model: Model) -> None:
    line = watched(model, record(3, 4), record(2, 4), samples=20.0)[8]
    samples = line["samples"]
    assert 18 <= len(samples["time"]) <= 25
    causes = np.sum([np.array(values, float) for values in samples["terms"].values()], axis=0)
    np.testing.assert_allclose(causes, np.array(samples["model"], float), atol=0.05)  # at reversals
    difference = np.array(samples["measured"], float) - np.array(samples["model"], float)
    np.testing.assert_allclose(difference, np.array(samples["residual"], float), atol=1e-4)


def test_healthy_recordings_of_another_motion_are_refused(model: Model) -> None:
    other = replace(record(2), run=replace_period(record(2), 3.0))
    with pytest.raises(BadInput, match="give --healthy"):
        watched(model, record(3), other)


def replace_period(recording: Recording, period: float) -> Any:
    return recording.run.model_copy(update={"period": period})


def test_motion_that_does_not_repeat_is_refused(model: Model) -> None:
    recording = record(3)
    with pytest.raises(BadInput, match="a motion that repeats expected"):
        watched(model, replace(recording, run=replace_period(recording, 0.0)))
