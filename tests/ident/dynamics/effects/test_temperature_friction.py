"""Friction that falls with the measured temperature of one axis."""

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building

SEEDS = [pytest.param(seed, marks=[pytest.mark.slow] if seed else []) for seed in range(5)]
K = -0.012


def warming(low: float, high: float) -> Floats:
    """(n, 1) temperature in steps of half a degree [degC]."""
    share = 1 - np.exp(-2 * np.linspace(0, 1, len(building.motion_of().position)))
    return np.round((low + (high - low) * share) / 0.5)[:, None] * 0.5


def recorded(seed: int, low: float, high: float, *, measured: bool = True) -> Recording:
    temperature = warming(low, high)

    def extra(motion: Motion) -> Floats:
        friction = building.VISCOUS * motion.velocity + building.COULOMB * motion.direction
        change: Floats = K * (temperature - 25.0) * friction
        return change

    return building.record(
        noise=0.05,
        seed=seed,
        shape=seed,
        extra=extra,
        temperature=temperature if measured else None,
        name=f"from {low} degC",
    )


@pytest.mark.parametrize("seed", SEEDS)
def test_is_named_where_friction_falls_with_the_temperature(seed: int) -> None:
    assert building.named(recorded(seed, 28, 45), recorded(seed + 1000, 40, 50))[0][0] == "temperature_friction"


def test_its_coefficient_and_the_friction_at_25_degrees_are_found() -> None:
    model = building.fitted(building.split([recorded(0, 28, 45)]), "temperature_friction")
    truth = [building.INERTIA, building.VISCOUS, building.COULOMB, K]
    np.testing.assert_allclose(model.solution.x, truth, rtol=0.03)


def test_is_not_offered_where_no_temperature_was_measured() -> None:
    recordings = recorded(0, 28, 45, measured=False), recorded(1000, 40, 50, measured=False)
    assert "temperature_friction" not in [name for names in building.named(*recordings) for name in names]
