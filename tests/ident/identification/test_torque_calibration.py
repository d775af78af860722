"""Planted gains, from torques that are exactly Eq. (26) with another platform mass."""

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
"""Places of m_p, T_g and c_c1 among the parameters."""
LOADED = {PLATFORM: PAYLOAD}
Record = Callable[..., Recording]


@pytest.fixture(scope="module")
def recorded(make: Make, truth: Floats) -> Record:
    """A recording of drives with other gains than the rig file says, with so much added to the parameters."""

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
def found(recorded: Record) -> Calibration:
    return calibrate(recorded(), recorded(LOADED, seed=1), PAYLOAD)


def test_planted_gains_are_within_their_intervals(found: Calibration) -> None:
    lowest, highest = found.intervals.T
    assert (lowest < GAINS).all()
    assert (highest > GAINS).all()
    np.testing.assert_allclose(found.torque.gain, GAINS, rtol=0.01)
    assert found.relative_std.max() < 0.01
    assert found.torque.gain_source == "calibrated"
    assert found.torque.gain_uncertainty == pytest.approx(found.relative_std.max())
    assert found.explained > 0.95
    assert found.gains_differ
    assert found.spread == pytest.approx(1.3 / 0.8 - 1, rel=0.02)


@pytest.mark.slow
def test_intervals_cover(recorded: Record) -> None:
    inside = 0
    for seed in range(0, 60, 2):
        pair = [recorded(added, seed=seed + i, cycles=1) for i, added in enumerate(({}, LOADED))]
        lowest, highest = calibrate(*pair, PAYLOAD).intervals[0]  # the joints' errors are nearly the same
        inside += bool(lowest < GAINS[0] < highest)
    assert inside >= 24  # of 30: 28.5 expected, fewer than 24 in one case of a thousand


def test_equal_gains_are_said_to_be_equal(recorded: Record) -> None:
    same = [recorded(added, gains=(1.2,) * 3, seed=i) for i, added in enumerate(({}, LOADED))]
    found = calibrate(*same, PAYLOAD)
    assert not found.differ
    np.testing.assert_allclose(found.torque.gain, 1.2, rtol=0.01)


def test_friction_may_change_between_the_recordings(recorded: Record) -> None:
    warm = recorded({**LOADED, COULOMB: -1.0, COULOMB + 1: 0.5}, seed=1)
    lowest, highest = calibrate(recorded(), warm, PAYLOAD).intervals.T
    assert ((lowest < GAINS) & (highest > GAINS)).all()


def test_calibrating_again_changes_nothing(found: Calibration, recorded: Callable[..., Recording]) -> None:
    empty = recorded()
    calibrated = replace(empty, rig=empty.rig.model_copy(update={"torque": found.torque}))
    again = replace(recorded(LOADED, seed=1), rig=calibrated.rig)
    np.testing.assert_allclose(calibrate(calibrated, again, PAYLOAD).torque.gain, found.torque.gain, rtol=1e-3)


def test_the_gain_goes_with_the_mass(found: Calibration, recorded: Record) -> None:
    doubled = calibrate(recorded(), recorded(LOADED, seed=1), 2 * PAYLOAD)
    np.testing.assert_allclose(doubled.torque.gain, 2 * np.array(found.torque.gain), rtol=1e-6)


def other_geometry(recording: Recording) -> Recording:
    return replace(recording, rig=recording.rig.model_copy(update={"geometry": Geometry(L2=0.81)}))


@pytest.mark.parametrize("payload", [0.0, -1.0, np.nan])
def test_an_impossible_payload_is_refused(recorded: Record, payload: float) -> None:
    with pytest.raises(BadInput, match="above 0 kg"):
        calibrate(recorded(), recorded(), payload)


def test_exchanged_files_are_noticed(recorded: Record) -> None:
    with pytest.raises(BadInput, match="exchange"):
        calibrate(recorded(LOADED), recorded(seed=1), PAYLOAD)


def test_no_payload_at_all_is_noticed(recorded: Record) -> None:
    with pytest.raises(BadInput, match=r"joint \d shows none"):
        calibrate(recorded(), recorded(seed=1), PAYLOAD)


def test_another_difference_is_not_taken_for_a_payload(recorded: Record) -> None:
    with pytest.raises(BadInput, match=r"explains only \d+ %"):
        calibrate(recorded(), recorded({ARMS: 3.0}, seed=1), PAYLOAD)


def test_a_payload_too_light_to_tell_is_refused(recorded: Record) -> None:
    pair = recorded(noise=0.5), recorded({PLATFORM: 0.05}, seed=1, noise=0.5)
    with pytest.raises(BadInput, match="heavier"):
        calibrate(*pair, 0.05)


def test_other_motions_and_rigs_are_refused(recorded: Record) -> None:
    with pytest.raises(BadInput, match="same motion"):
        calibrate(recorded(), recorded(LOADED, trajectory="fig5b"), PAYLOAD)
    with pytest.raises(BadInput, match="same rig"):
        calibrate(recorded(), other_geometry(recorded(LOADED)), PAYLOAD)
    axes = simulated_rig().model_copy(update={"mechanism": "axes", "axes": (Axis(),) * 3})
    pair = [replace(recorded(added), rig=axes) for added in ({}, LOADED)]
    with pytest.raises(BadInput, match="carries a payload"):
        calibrate(*pair, PAYLOAD)
