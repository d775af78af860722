"""Calibration of planted gains, with torques that are exactly Eq. (26) with different platform masses."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType

import numpy as np
import pytest

from ident.identification.torque_calibration import Calibration, calibrate
from recordings.errors import BadInput
from recordings.recording import Floats, Recording
from recordings.rig import Axis, Geometry, simulated_rig

Make = Callable[..., Recording]
GAINS = (0.8, 1.0, 1.3)
PAYLOAD = 1.5
PLATFORM, ARMS, COULOMB = 0, 1, 8
"""Indices of m_p, T_g and c_c1 among the parameters."""
LOADED = {PLATFORM: PAYLOAD}
Record = Callable[..., Recording]


@pytest.fixture(scope="module")
def recorded(make: Make, truth: Floats) -> Record:
    """Return a function that records drives with gains that differ from the rig file, with changed parameters."""

    def record(
        added: Mapping[int, float] = MappingProxyType({}), gains: tuple[float, ...] = GAINS, **kind: object
    ) -> Recording:
        rig = simulated_rig()
        true = rig.model_copy(update={"torque": rig.torque.model_copy(update={"gain": gains})})
        parameters = truth.copy()
        parameters[list(added)] += list(added.values())
        return replace(make(rig=true, parameters=parameters, **{"noise": 0.02, **kind}), rig=rig)

    return record


@pytest.fixture(scope="module")
def calibration(recorded: Record) -> Calibration:
    return calibrate(recorded(), recorded(LOADED, seed=1), PAYLOAD)


def test_planted_gains_are_within_their_intervals(calibration: Calibration) -> None:
    lowest, highest = calibration.intervals.T
    assert (lowest < GAINS).all()
    assert (highest > GAINS).all()
    np.testing.assert_allclose(calibration.torque.gain, GAINS, rtol=0.01)
    assert calibration.relative_std.max() < 0.01
    assert calibration.torque.gain_source == "calibrated"
    assert calibration.torque.gain_uncertainty == pytest.approx(calibration.relative_std.max())
    assert calibration.explained > 0.95
    assert calibration.gains_differ
    assert calibration.spread == pytest.approx(1.3 / 0.8 - 1, rel=0.02)


@pytest.mark.slow
def test_intervals_cover_the_true_gains(recorded: Record) -> None:
    inside = 0
    for seed in range(0, 60, 2):
        pair = [recorded(added, seed=seed + i, cycles=1) for i, added in enumerate(({}, LOADED))]
        lowest, highest = calibrate(*pair, PAYLOAD).intervals[0]  # the joints' errors are nearly the same
        inside += bool(lowest < GAINS[0] < highest)
    assert inside >= 24  # of 30: 28.5 expected, fewer than 24 in one case of a thousand


def test_equal_gains_are_not_reported_as_different(recorded: Record) -> None:
    same = [recorded(added, gains=(1.2,) * 3, seed=i) for i, added in enumerate(({}, LOADED))]
    calibration = calibrate(*same, PAYLOAD)
    assert not calibration.gains_differ
    np.testing.assert_allclose(calibration.torque.gain, 1.2, rtol=0.01)


def test_friction_may_change_between_the_recordings(recorded: Record) -> None:
    warm = recorded({**LOADED, COULOMB: -1.0, COULOMB + 1: 0.5}, seed=1)
    lowest, highest = calibrate(recorded(), warm, PAYLOAD).intervals.T
    assert ((lowest < GAINS) & (highest > GAINS)).all()


def test_calibrating_again_changes_nothing(calibration: Calibration, recorded: Callable[..., Recording]) -> None:
    empty = recorded()
    calibrated = replace(empty, rig=empty.rig.model_copy(update={"torque": calibration.torque}))
    again = replace(recorded(LOADED, seed=1), rig=calibrated.rig)
    np.testing.assert_allclose(calibrate(calibrated, again, PAYLOAD).torque.gain, calibration.torque.gain, rtol=1e-3)


def test_gains_are_proportional_to_the_payload(calibration: Calibration, recorded: Record) -> None:
    doubled = calibrate(recorded(), recorded(LOADED, seed=1), 2 * PAYLOAD)
    np.testing.assert_allclose(doubled.torque.gain, 2 * np.array(calibration.torque.gain), rtol=1e-6)


def with_longer_rods(recording: Recording) -> Recording:
    return replace(recording, rig=recording.rig.model_copy(update={"geometry": Geometry(L2=0.81)}))


@pytest.mark.parametrize("payload", [0.0, -1.0, np.nan])
def test_an_impossible_payload_is_refused(recorded: Record, payload: float) -> None:
    with pytest.raises(BadInput, match="above 0 kg"):
        calibrate(recorded(), recorded(), payload)


def test_exchanged_files_are_refused(recorded: Record) -> None:
    with pytest.raises(BadInput, match="exchange"):
        calibrate(recorded(LOADED), recorded(seed=1), PAYLOAD)


def test_a_missing_payload_is_refused(recorded: Record) -> None:
    with pytest.raises(BadInput, match=r"joint \d shows none"):
        calibrate(recorded(), recorded(seed=1), PAYLOAD)


def test_a_difference_other_than_a_payload_is_refused(recorded: Record) -> None:
    with pytest.raises(BadInput, match=r"explains only \d+ %"):
        calibrate(recorded(), recorded({ARMS: 3.0}, seed=1), PAYLOAD)


def test_a_payload_that_is_too_light_is_refused(recorded: Record) -> None:
    pair = recorded(noise=0.5), recorded({PLATFORM: 0.05}, seed=1, noise=0.5)
    with pytest.raises(BadInput, match="heavier"):
        calibrate(*pair, 0.05)


def test_different_motions_and_rigs_are_refused(recorded: Record) -> None:
    with pytest.raises(BadInput, match="same motion"):
        calibrate(recorded(), recorded(LOADED, trajectory="fig5b"), PAYLOAD)
    with pytest.raises(BadInput, match="same rig"):
        calibrate(recorded(), with_longer_rods(recorded(LOADED)), PAYLOAD)
    axes = simulated_rig().model_copy(update={"mechanism": "axes", "axes": (Axis(),) * 3})
    pair = [replace(recorded(added), rig=axes) for added in ({}, LOADED)]
    with pytest.raises(BadInput, match="carries a payload"):
        calibrate(*pair, PAYLOAD)
