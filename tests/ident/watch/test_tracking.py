"""Parameters that are followed: as fitted on the same robot, and as they are on another one."""

import numpy as np
import pytest

from ident.identification.model import Model
from recordings.errors import BadInput
from tests.ident import building
from tests.ident.watch.test_watching import ONSET, changed, friction, model, record, watched

__all__ = ["model"]


def test_parameter_follows_a_change_and_its_interval_covers_it(model: Model) -> None:
    recording = record(3, 20)
    size = 0.15
    lines = watched(model, changed(recording, friction(recording, size)), track=["c_c2", "c_v1"])
    told = [(line["time"], line["parameters"]) for line in lines if "parameters" in line]
    value = np.array([each["c_c2"]["value"] for _, each in told])
    low, high = np.array([each["c_c2"]["ci95"] for _, each in told]).T
    time = np.array([time for time, _ in told])
    truth = building.COULOMB + np.where(time > ONSET, size, 0.0)
    settled = (time < ONSET) | (time > ONSET + 50)
    assert np.abs(value - truth)[settled].max() < 0.03
    assert ((low <= truth) & (truth <= high))[time < ONSET].mean() > 0.8
    assert (high - low).max() < 0.2
    unchanged = [each["c_v1"]["value"] for _, each in told]
    assert np.abs(np.array(unchanged) - building.VISCOUS).max() < 0.03


def test_unknown_parameter_is_refused(model: Model) -> None:
    with pytest.raises(BadInput, match="did you mean c_c2"):
        watched(model, record(3, 4), track=["c_c22"])
