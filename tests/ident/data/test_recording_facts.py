"""What a recording holds: sampling, resolution, motions."""

from dataclasses import replace

import numpy as np
import pytest

from ident.data.recording_facts import recording_facts
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


def test_a_drift_has_one_direction() -> None:
    joint = recording_facts([building.prepared(building.record(drift=20.0))]).joints[0]
    assert joint.forward_share == 1
    assert joint.rarer_direction == 0


def test_several_recordings_count_together() -> None:
    narrow, wide = (building.prepared(building.record(size=size)) for size in (0.5, 1.0))
    together = recording_facts([narrow, wide])
    assert together.duration_s == pytest.approx(2 * recording_facts([narrow]).duration_s)
    assert together.joints[0].travel == pytest.approx(recording_facts([wide]).joints[0].travel)
