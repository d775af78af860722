"""Calibration of planted gains, with torques that are exactly Eq. (26) with different platform masses."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

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


def test_calibrating_again_changes_nothing_and_gains_are_proportional_to_the_payload(
    calibration: Calibration, recorded: Record
) -> None:
    empty, loaded = recorded(), recorded(LOADED, seed=1)
    calibrated = empty.rig.model_copy(update={"torque": calibration.torque})
    again = calibrate(replace(empty, rig=calibrated), replace(loaded, rig=calibrated), PAYLOAD)
    np.testing.assert_allclose(again.torque.gain, calibration.torque.gain, rtol=1e-3)
    doubled = calibrate(empty, loaded, 2 * PAYLOAD)
    np.testing.assert_allclose(doubled.torque.gain, 2 * np.array(calibration.torque.gain), rtol=1e-6)


@pytest.mark.parametrize(
    ("empty", "loaded", "payload", "reason"),
    [
        *(({}, {}, payload, "above 0 kg") for payload in (0.0, -1.0, np.nan)),
        ({"added": LOADED}, {}, PAYLOAD, "exchange"),
        ({}, {}, PAYLOAD, r"joint \d shows none"),
        ({}, {"added": {ARMS: 3.0}}, PAYLOAD, r"explains only \d+ %"),
        ({"noise": 0.5}, {"added": {PLATFORM: 0.05}, "noise": 0.5}, 0.05, "heavier"),
        ({}, {"added": LOADED, "trajectory": "fig5b", "seed": 0}, PAYLOAD, "same motion"),
    ],
)
def test_a_difference_other_than_the_payload_is_refused(
    recorded: Record, empty: dict[str, Any], loaded: dict[str, Any], payload: float, reason: str
) -> None:
    with pytest.raises(BadInput, match=reason):
        calibrate(recorded(**empty), recorded(**{"seed": 1, **loaded}), payload)


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        (({}, {"geometry": Geometry(L2=0.81)}), "same rig"),
        (({"mechanism": "axes", "axes": (Axis(),) * 3},) * 2, "carries a payload"),
    ],
)
def test_different_rigs_are_refused(recorded: Record, changes: tuple[dict[str, Any], ...], reason: str) -> None:
    pair = [
        replace(recorded(added), rig=simulated_rig().model_copy(update=change))
        for added, change in zip(({}, LOADED), changes, strict=True)
    ]
    with pytest.raises(BadInput, match=reason):
        calibrate(*pair, PAYLOAD)
