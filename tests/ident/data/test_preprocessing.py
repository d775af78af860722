from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from ident.data import preprocessing
from ident.data.cutoff import Cutoff
from ident.data.prepared_recording import prepare
from ident.data.samples import Samples
from recordings.errors import BadInput
from recordings.recording import Floats, Ints, Recording

Make = Callable[..., Recording]


def samples(position: Floats, torque: Floats, rate: float, repeat: Ints | None = None) -> Samples:
    """Samples with the signals (n, dof), all of them selected."""
    n = len(position)
    repeat = np.zeros(n, np.int64) if repeat is None else repeat
    return Samples(
        rate=rate,
        window=1 / rate,
        position=position,
        drive=torque,
        torque=torque,
        slope=np.ones_like(torque),
        repeat=repeat,
        phase=np.arange(n) / rate,
        temperature=np.full_like(position, np.nan),
        selected=np.ones(n, bool),
    )


def relative_residual(recording: Recording, parameters: Floats, method: str, cutoff: float | None = None) -> float:
    prepared = prepare(recording, method, cutoff)
    regressor, torque = prepared.regressor[prepared.usable], prepared.torque[prepared.usable]
    return float(np.sqrt(np.mean((torque - regressor @ parameters) ** 2)) / torque.std())


@pytest.mark.parametrize(("rate", "cutoff"), [(500, None), (500, 10), (1000, 40), (200, None)])
def test_parallel_filtering_of_exact_motion_leaves_a_small_residual(
    make: Make, truth: Floats, rate: float, cutoff: float | None
) -> None:
    assert relative_residual(make(rate=rate, cycles=1), truth, "parallel", cutoff) < 2e-3 * (200 / rate)


def test_parallel_filtering_is_robust_against_encoder_quantization(make: Make, truth: Floats) -> None:
    recording = make()
    counts = recording.rig.drives[0].counts_per_radian
    coarse = replace(recording, position=np.round(recording.position * counts) / counts)
    assert relative_residual(coarse, truth, "parallel") < 0.01
    # With central differences, encoder noise dominates.
    assert relative_residual(coarse, truth, "central") > 0.1


def test_central_differences_are_those_of_the_paper() -> None:
    t = np.arange(50) / 100
    position, torque = np.sin(3 * t)[:, None], np.cos(t)[:, None]
    preprocessed = preprocessing.load("central")(samples(position, torque, 100.0), None)
    inner = slice(1, -1)
    np.testing.assert_allclose(preprocessed.motion.velocity[inner], (position[2:] - position[:-2]) * 50)
    np.testing.assert_allclose(
        preprocessed.motion.acceleration[inner], (position[2:] - 2 * position[1:-1] + position[:-2]) * 1e4, atol=1e-9
    )
    np.testing.assert_array_equal(preprocessed.motion.direction[inner], np.sign(preprocessed.motion.velocity[inner]))
    np.testing.assert_array_equal(preprocessed.condition(torque), torque)
    assert np.isnan(preprocessed.motion.velocity[[0, -1]]).all()


@pytest.mark.parametrize("method", ["central", "parallel", "savgol"])
@pytest.mark.parametrize("signal", ["position", "voltage"])
def test_a_gap_affects_only_samples_within_the_filters_length(
    recording: Recording, truth: Floats, method: str, signal: str
) -> None:
    gap = slice(1000, 1003)
    values = getattr(recording, signal).copy()
    values[gap, 1] = np.nan
    gapped = replace(recording, **{signal: values})
    expected, result = (prepare(source, method, None) for source in (recording, gapped))
    lost = np.isfinite(expected.torque) & np.isnan(result.torque)
    # At most, parallel at 30 Hz: 25 samples to either side, 9 more of the light filter and 4 of the derivatives.
    lost_time = expected.time[lost.any(axis=1)]
    assert abs(lost_time - 1001 / 500).max() < 0.081
    # Without its voltage one joint is lost, without its position the whole platform.
    assert lost.any(axis=0).tolist() == ([False, True, False] if signal == "voltage" else [True] * 3)
    np.testing.assert_array_equal(result.torque[~lost], expected.torque[~lost])
    assert relative_residual(gapped, truth, method) == pytest.approx(relative_residual(recording, truth, method), 0.1)


@pytest.mark.parametrize(
    ("method", "cutoff", "reason"),
    [
        *(("parallel", cutoff, "cut-off") for cutoff in (0, -5, 101, np.nan)),
        ("central", 30.0, "no cut-off"),
        ("magic", None, "central, cycle_average, fourier, parallel, savgol"),
    ],
)
def test_impossible_settings_are_refused(
    recording: Recording, method: str, cutoff: float | None, reason: str
) -> None:
    with pytest.raises(BadInput, match=reason):
        prepare(recording, method, cutoff)


@pytest.mark.parametrize("method", ["fourier", "cycle_average"])
def test_fourier_differentiation_of_a_periodic_motion_is_exact(method: str) -> None:
    t = np.arange(400) / 100
    omega = 2 * np.pi / 2
    position = np.stack([np.sin(omega * t), np.cos(3 * omega * t)], axis=1)
    periodic = samples(position, position**2, 100.0, (t >= 2).astype(np.int64))
    preprocessed = preprocessing.load(method)(periodic, Cutoff(10.0, "given"))
    expected = np.stack([omega * np.cos(omega * t), -3 * omega * np.sin(3 * omega * t)], axis=1)
    n = len(preprocessed.instants)
    assert n == (400 if method == "fourier" else 200)
    np.testing.assert_allclose(preprocessed.motion.velocity, expected[:n], atol=1e-9)
    np.testing.assert_allclose(
        preprocessed.motion.acceleration, -(np.array([1, 9]) * omega**2 * position)[:n], atol=1e-8
    )
    np.testing.assert_allclose(preprocessed.torque, (position**2)[:n], atol=1e-9)
    assert np.isfinite(preprocessed.motion.direction).all()


def test_the_mean_cycle_has_less_noise_and_no_gaps(make: Make, truth: Floats) -> None:
    recording = make(cycles=4, noise=0.05)
    gapped = replace(recording, position=recording.position.copy())
    gapped.position[2000:2010] = np.nan
    without_average, averaged = (
        relative_residual(source, truth, method)
        for source, method in ((recording, "fourier"), (gapped, "cycle_average"))
    )
    assert averaged == pytest.approx(without_average / 2, rel=0.3)


HALVES = np.repeat([0, 1], 200)


@pytest.mark.parametrize(
    ("method", "repeat", "gaps", "message"),
    [
        ("fourier", np.full(400, -1), [], "cycles of no samples found"),
        ("fourier", np.repeat([0, 1], [150, 250]), [], "cycles of 150, 250 samples found"),
        ("cycle_average", np.tile([0, 1], 200), [], "one after the other"),
        ("fourier", HALVES, [50, 250], "choose cycle_average or parallel"),
        ("cycle_average", HALVES, [50, 250], "at every phase in at least one cycle"),
    ],
)
def test_fourier_methods_need_whole_cycles(method: str, repeat: Ints, gaps: list[int], message: str) -> None:
    position = np.sin(np.arange(400) * 2 * np.pi / 200)[:, None]
    torque = position.copy()
    torque[gaps] = np.nan
    with pytest.raises(BadInput, match=message):
        preprocessing.load(method)(samples(position, torque, 100.0, repeat), Cutoff(5.0, "given"))


@pytest.mark.parametrize("cutoff", [4.0, 9.0, 20.0])
def test_savitzky_golay_smooths_by_three_decibels_at_the_cutoff(cutoff: float) -> None:
    t = np.arange(1000) / 200
    wave = np.cos(2 * np.pi * cutoff * t)[:, None]
    preprocessed = preprocessing.load("savgol")(samples(wave, wave, 200.0), Cutoff(cutoff, "given"))
    assert np.nanmax(preprocessed.torque) == pytest.approx(np.sqrt(0.5), abs=0.05)
    np.testing.assert_allclose(preprocessed.condition(wave), preprocessed.torque)
