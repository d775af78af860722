"""Ripple above the low-pass: the band, waves over the angle and over time, and what stands in the model."""

import numpy as np
import pytest

import ident
from ident.diagnosis.document.document import Document
from ident.diagnosis.ripple.high_band import HIGHEST_SHARE, high_bands
from ident.diagnosis.ripple.ripple import EFFECT, Ripple, find_ripple
from ident.diagnosis.ripple.ripple_line import BandEvidence, RippleLine
from ident.diagnosis.ripple.ripple_search import search
from ident.diagnosis.ripple.vibration_alternative import VIBRATION, with_vibration_alternatives
from ident.diagnosis.ripple.waves import JointSignal, Vibration
from ident.dynamics.effects.library import library
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

FAST, SLOW = 80.0, 3.0


def _sine(hertz: float) -> Floats:
    return np.sin(2 * np.pi * hertz * np.arange(4000) / building.RATE)[:, None]


@pytest.mark.parametrize(("hertz", "share"), [(FAST, 1.0), (SLOW, 0.0)])
def test_only_what_the_low_pass_removes_is_left(hertz: float, share: float) -> None:
    """Up to any frequency; no sample belongs both to training rows and to test rows."""
    model = building.fitted(building.split([building.record(extra=lambda motion: _sine(hertz))]))
    (band,) = high_bands(model.split, model.solution)
    assert np.nanstd(band.residual) == pytest.approx(share / np.sqrt(2), abs=0.05)
    assert (band.prepared.bandwidth, band.highest) == (building.CUTOFF, HIGHEST_SHARE * building.RATE)
    assert np.nanstd(band.within(_sine(FAST), 20.0, 40.0)) < 0.05
    assert band.train.any()
    assert band.test.any()
    assert not (band.train & band.test).any()


RATE = 500.0
ENCODER_STEP = 1e-6


def _waves(
    extra: building.Torque, seed: int = 0, noise: float = 0.2, step: float = ENCODER_STEP
) -> tuple[list[RippleLine], list[Vibration]]:
    recording = building.record(extra=extra, noise=noise, seed=seed, rate=RATE)
    model = building.fitted(building.split([recording]))
    return search(JointSignal(high_bands(model.split, model.solution), 0), step)


def _over_angle(motion: Motion) -> Floats:
    return 0.2 * np.sin(160.0 * motion.position) + 0.15 * np.cos(200.0 * motion.position)


def _over_time(motion: Motion) -> Floats:
    return 0.2 * np.sin(2 * np.pi * 50.0 * np.arange(len(motion.position)) / RATE)[:, None] + 0 * motion.position


def test_waves_over_the_angle_are_found_with_amplitude_and_interval() -> None:
    lines, vibrations = _waves(_over_angle)
    assert len(lines) == 2
    for line, order, amplitude in zip(lines, (160.0, 200.0), (0.2, 0.15), strict=True):
        assert abs(line.order - order) < 2 * line.half_width[2] < 0.3
        assert line.amplitude == pytest.approx(amplitude, rel=0.2)
        assert line.same_frequency is None  # the speed varies
    assert not vibrations


def test_a_wave_over_time_is_a_vibration_and_no_ripple() -> None:
    lines, (vibration,) = _waves(_over_time)
    assert not lines
    assert vibration.frequency == pytest.approx(50.0, abs=0.05)
    assert vibration.amplitude == pytest.approx(0.2, rel=0.1)


@pytest.mark.parametrize("seed", range(10))
def test_noise_has_no_waves(seed: int) -> None:
    assert _waves(lambda motion: 0 * motion.position, seed) == ([], [])


def test_waves_of_the_size_of_encoder_steps_are_not_searched() -> None:
    assert _waves(_over_angle, step=1 / 100)[0] == []


@pytest.mark.slow
def test_interval_of_the_order_covers_the_truth() -> None:
    inside = 0
    for seed in range(60):
        (line, *_), _ = _waves(lambda motion: 0.2 * np.sin(160.0 * motion.position), seed)
        inside += abs(line.order - 160.0) < line.half_width[2]
    assert 52 <= inside <= 60  # 95 % of 60, within chance of 1 in 1000


def ripple_of_second_joint(motion: Motion) -> Floats:
    return 0.2 * np.sin(160.0 * motion.position) * [0.0, 1.0]


def found(without: tuple[str, ...] = ()) -> Ripple:
    train, test = (
        building.record(2, noise=0.1, extra=ripple_of_second_joint, rate=500.0, shape=shape, seed=shape)
        for shape in (0, 1)
    )
    effects = {name: effect for name, effect in library().items() if name not in without}
    return find_ripple(building.fitted(building.split([train], [test])), effects)


def test_lines_explain_the_ripple_of_their_joint_only() -> None:
    ripple, without = found(), found(without=(EFFECT,))
    assert [line.joint for line in ripple.lines] == [1]
    before, after = (ripple.errors(ripple.model, lines)["held_out_rms"] for lines in (False, True))
    assert after[0] == pytest.approx(before[0])
    assert after[1] < 0.8 * before[1]
    assert [term.name for term in ripple.structure.terms] == [EFFECT]
    assert ripple.structure.shape_values(0, ripple.x) == pytest.approx([160.0], abs=0.1)
    assert len(ripple.half_widths) == 3
    assert (ripple.with_noise(np.zeros(2)) > 0).all()  # of cycles that repeat
    orders, amplitude = ripple.order_spectrum(1, with_lines=False)
    assert orders[amplitude.argmax()] == pytest.approx(160.0, abs=1.0)
    assert ripple.upper > ripple.low
    assert (without.lines, without.upper) == ((), without.low)
    assert without.unexplained_share[1] > 1.2 * ripple.unexplained_share[1]


def diagnosed(extra: building.Torque, **options: float) -> tuple[Document, Ripple]:
    train, test = (
        building.record(noise=0.05, extra=extra, rate=500.0, shape=shape, seed=shape, size=0.5, name=f"{shape}")
        for shape in (0, 1)
    )
    result = ident.diagnose(train, validate=test, **options)
    return result.document, result.diagnosis.ripple


def test_a_line_above_the_low_pass_acts_below_it_as_well() -> None:
    document, ripple = diagnosed(lambda motion: 0.3 * np.sin(200.0 * motion.position), cutoff=8.0)
    assert [line.order for line in ripple.lines] == pytest.approx([200.0], abs=0.1)
    assert document.verdict == "missing-effect"
    before, after = (ripple.errors(ripple.model, lines)["held_out_rms"][0] for lines in (False, True))
    below = np.sqrt(np.nanmean(ripple.whole.residuals[1] ** 2))
    assert below < 0.7 * np.sqrt(np.nanmean(ripple.model.residuals[1] ** 2))
    assert after < 0.5 * before


def test_interval_of_an_order_covers_what_a_delay_shifts() -> None:
    """Within the low-pass alone it is 200.06 to 200.11, as noise is all that it knows."""
    document, _ = diagnosed(lambda motion: 0.3 * np.sin(200.0 * (motion.position - 0.002 * motion.velocity)))
    low, high = document.steps[-1].parameters["cogging.N"].ci95 or (0.0, 0.0)
    assert 195.0 < low < 200.0 < high < 205.0


@pytest.mark.parametrize(("left", "pays"), [(0.97, False), (0.9, True)])
def test_a_wave_that_is_negligible_in_its_band_does_not_pay(left: float, pays: bool) -> None:
    """However certain it is that there is one."""
    recording = building.record(rate=RATE, extra=lambda motion: 0.3 * np.sin(160.0 * motion.position))
    model = building.fitted(building.split([recording]))
    signal = JointSignal(high_bands(model.split, model.solution), 0)
    evidence = BandEvidence.of(signal, 160.0, *[(signal.residual, left * signal.residual)] * 2)
    assert evidence.improvement.is_supported
    assert evidence.after == pytest.approx(left * evidence.before)
    assert evidence.pays is pays


@pytest.mark.parametrize(
    ("size", "drifts", "uncertain"), [(1.0, (0.0,), False), (5e-5, (2.0,), True), (5e-5, (2.0, 3.0), False)]
)
def test_at_one_speed_a_vibration_explains_what_ripple_does(
    size: float, drifts: tuple[float, ...], uncertain: bool
) -> None:
    """A vibration keeps its frequency where recordings have different speeds."""
    recordings = [
        building.record(
            noise=0.05,
            extra=lambda motion: 0.4 * np.sin(20.0 * motion.position),
            size=size,
            drift=drift,
            name=str(drift),
        )
        for drift in drifts
    ]
    search, begin = building.search(building.split(recordings), {"cogging": library()["cogging"]})
    (finding, *_) = with_vibration_alternatives(search.select(*begin)).findings
    assert (VIBRATION in finding.alternatives) is uncertain
