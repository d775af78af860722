"""Friction by a power of the speed, in place of viscous friction."""

import numpy as np
import pytest

from tests.ident import building


@pytest.mark.parametrize("alpha", [0.3, 0.6, 0.75])
def test_its_power_is_found_and_viscous_friction_is_gone(alpha: float) -> None:
    power = building.of_size(lambda motion: np.abs(motion.velocity) ** alpha * motion.direction, 0.03)
    recording = building.record(noise=0.05, extra=lambda motion: power(motion) - building.VISCOUS * motion.velocity)
    model = building.structure(recording, "power_law_friction")
    start = building.start(model)
    start[-1] = 0.55
    x = building.split([recording]).fit(model, start).x
    values = dict(zip([entry.name for entry in model.parameters], x, strict=True))
    assert values["power_law_friction.alpha"] == pytest.approx(alpha, abs=0.1)
    assert values["c_v1"] == 0.0
    assert "c_v1" not in [parameter.name for parameter in model.linear_parameters]
