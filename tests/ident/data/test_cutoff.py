"""The cut-off of the low-pass, chosen from the spectra."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.basics import slicing
from ident.data.cutoff import (
    choose,
    choose_common,
    given_or_chosen,
)
from ident.data.prepared_recording import prepare, prepare_all
from ident.data.samples import sample
from ident.dynamics.torque_map import torque_from_voltage
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from tests.ident import building

Make = Callable[..., Recording]


def signals(recording: Recording, bits: int | None = None) -> tuple[Floats, Floats, float]:
    position = recording.position
    if bits is not None:
        counts = 2**bits / (2 * np.pi)
        position = np.round(position * counts) / counts
    return position, torque_from_voltage(recording.voltage, recording.rig.torque), recording.run.rate


@pytest.fixture(scope="module")
def noisy(make: Make) -> Recording:
    return make(cycles=2, noise=0.01)


@pytest.mark.parametrize(
    ("bits", "hz", "reason"),
    [(12, 10, "encoder"), (14, 23, "encoder"), (17, 28, "encoder"), (19, 30, "usual"), (None, 30, "usual")],
)
def test_a_coarse_encoder_lowers_the_cutoff(noisy: Recording, bits: int | None, hz: float, reason: str) -> None:
    cutoff = choose(*signals(noisy, bits))
    assert cutoff.reason == reason
    assert cutoff.hz == pytest.approx(hz, rel=0.1)


def test_a_slow_recording_lowers_the_cutoff_and_a_torque_of_larger_bandwidth_raises_it(make: Make) -> None:
    slow = choose(*signals(make(cycles=2, rate=60, noise=0.01)))
    assert (slow.hz, slow.reason) == (12, "rate")
    t = np.arange(20000) / 1000
    wave = np.sin(2 * np.pi * 70 * t)[:, None]
    noise = np.random.default_rng(0).normal(0, 0.01, wave.shape)
    wide = choose(np.sin(2 * t)[:, None] + 1e-3 * wave, wave + noise, 1000.0)
    assert wide.reason == "signal"
    assert wide.hz == pytest.approx(70, abs=3)
    slow_too = choose(
        np.sin(2 * t)[:, None] * [1, 1], wave * [1, 0] + np.sin(2 * t)[:, None] * [0, 1] + noise, 1000.0
    )
    assert slow_too.reason == "usual", "the ripple of one joint does not raise the cut-off of all"


def test_a_gap_does_not_change_the_cutoff(noisy: Recording) -> None:
    position, torque, rate = signals(noisy, 12)
    position[1500:1503] = np.nan
    assert choose(position, torque, rate).hz == pytest.approx(10, abs=1)


def test_a_lower_cutoff_is_not_chosen_where_it_would_lose_much_of_the_torque(noisy: Recording) -> None:
    position, torque, rate = signals(noisy, 16)
    lower = choose(position, torque, rate).hz
    ripple = 0.6 * torque.std() * np.sin(2 * np.pi * 27.0 * np.arange(len(torque)) / rate)[:, None]
    assert lower < 25.0
    assert choose(position, torque + ripple, rate).hz > 27.0


def test_recordings_that_are_analysed_together_have_the_lowest_cutoff(noisy: Recording) -> None:
    counts = 2**15 / (2 * np.pi)
    coarse = replace(noisy, position=np.round(noisy.position * counts) / counts)
    alone = [choose_common([each]) for each in (noisy, coarse)]
    assert choose_common([coarse, noisy]) == alone[1]
    assert [each.cutoff for each in prepare_all([noisy, coarse], "parallel", None)] == [alone[1]] * 2
    assert alone[1].hz < alone[0].hz


def test_a_given_cutoff_is_used_if_the_rate_permits_it(noisy: Recording) -> None:
    assert given_or_chosen(45.0, sample(noisy)).sentence() == "45 Hz, as given"
    with pytest.raises(BadInput, match="a fifth of the rate"):
        given_or_chosen(101.0, sample(noisy))
    assert "chosen from the spectra" in given_or_chosen(None, sample(noisy)).sentence()
    assert choose(np.zeros((50, 1)), np.zeros((50, 1)), 500.0).reason == "usual"  # too short for spectra


def slow(gap: float) -> Recording:
    """A minute of the axis of a bench at 25 Hz with jitter, and a gap [s] in every second."""
    rng = np.random.default_rng(3)
    time = np.arange(1500) / 25 + rng.uniform(-0.004, 0.004, 1500)
    time = time[time % 1.0 >= gap]
    time -= time[0]
    waves = [(1.3, 1.0, 0.0), (2.1, 0.6, 1.0), (0.7, 0.5, 2.0)]
    q, qd, qdd = (sum(a * w**k * np.sin(w * time + p + k * np.pi / 2) for w, a, p in waves) for k in range(3))
    effort = building.INERTIA * qdd + building.VISCOUS * qd + building.COULOMB * np.sign(qd)
    recording = building.record(cycles=1)
    rows = np.arange(len(time))
    return replace(
        slicing.along_time(recording, rows % len(recording.time)),
        time=time,
        position=q[:, None],
        command=q[:, None],
        effort=effort[:, None],
        repeat=np.full(len(time), -1),
        run=recording.run.model_copy(update={"rate": 25.0, "period": 0.0, "cycles": 0}),
    )


def test_gaps_that_leave_hardly_a_row_lower_the_cutoff_which_closes_them() -> None:
    assert choose_common([slow(0.0)]).reason == "rate"
    gaps = slow(0.3)
    cutoff = choose_common([gaps])
    assert (cutoff.reason, 0.3 < cutoff.gap < 0.5, 1 < cutoff.hz < 3) == ("gaps", True, True)
    assert f"gaps of up to {cutoff.gap:.2g} s" in cutoff.sentence()
    for asked in (None, cutoff, cutoff.hz):
        prepared = prepare(gaps, "parallel", asked)
        rows = prepared.usable[:, 0]
        assert rows.mean() > 0.8
        found = np.linalg.lstsq(prepared.regressor[rows, 0], prepared.torque[rows, 0], rcond=None)[0]
        np.testing.assert_allclose(found, building.parameters(), rtol=0.05)


def test_cutoff_stays_where_rows_are_left_between_gaps() -> None:
    recording = slow(0.0)
    kept = np.ones(len(recording.time), bool)
    kept[700:710] = False
    assert choose_common([slicing.along_time(recording, kept)]).gap == 0.0


def test_gaps_that_the_chosen_cutoff_can_close_are_closed() -> None:
    """Of a recording at 1 kHz, every thirteenth sample or so is lost."""
    recording = building.record(cycles=2, rate=1000.0)
    kept = np.random.default_rng(5).random(len(recording.time)) > 0.075
    lossy = slicing.along_time(recording, kept)
    cutoff = choose_common([lossy])
    assert (cutoff.reason, cutoff.gap > 0.002) == ("usual", True)
    for asked in (None, cutoff.hz):
        assert prepare(lossy, "parallel", asked).usable.mean() > 0.8
