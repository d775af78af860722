"""Friction by a power of the speed: found, and not found, on one axis."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from recordings.recording import Floats, Recording
from tests.ident import building

NOISE = 0.05
SHARE = 0.03
SEEDS = [pytest.param(seed, marks=[pytest.mark.slow] if seed > 1 else []) for seed in range(20)]
Law = Callable[[Motion], Floats]


def pair(seed: int, extra: Law | None) -> list[Recording]:
    """A training motion and another one for validation."""
    return [
        building.record(noise=NOISE, seed=2 * seed + i, shape=shape, extra=extra, name=f"motion {i}")
        for i, shape in enumerate((seed, seed + 1000))
    ]


def power_law(seed: int) -> tuple[float, Law]:
    """A power below 1, and the friction that takes the place of the viscous one of the bench."""
    alpha = float(np.random.default_rng(seed).uniform(0.3, 0.75))
    power = building.of_size(lambda motion: np.abs(motion.velocity) ** alpha * motion.direction, SHARE, shape=seed)
    return alpha, lambda motion: power(motion) - building.VISCOUS * motion.velocity


@pytest.mark.parametrize("seed", SEEDS)
def test_is_named_where_it_takes_the_place_of_viscous_friction(seed: int) -> None:
    assert building.named(*pair(seed, power_law(seed)[1]))[0][0] == "power_law_friction"


@pytest.mark.parametrize("seed", SEEDS)
def test_viscous_friction_is_not_taken_for_it(seed: int) -> None:
    assert building.named(*pair(seed, None)) == []


@pytest.mark.parametrize("seed", SEEDS)
def test_quadratic_friction_is_not_taken_for_it(seed: int) -> None:
    drag = building.of_size(lambda motion: motion.velocity * np.abs(motion.velocity), SHARE, shape=seed)
    assert [names[0] for names in building.named(*pair(seed, drag))] == ["quadratic_friction"]


@pytest.mark.parametrize("seed", SEEDS)
def test_its_power_is_found_and_viscous_friction_is_gone(seed: int) -> None:
    alpha, torque = power_law(seed)
    recording, _ = pair(seed, torque)
    model = building.structure(recording, "power_law_friction")
    start = building.start(model)
    start[-1] = 0.55
    x = building.split([recording]).fit(model, start).x
    values = dict(zip([entry.name for entry in model.parameters], x, strict=True))
    assert values["power_law_friction.alpha"] == pytest.approx(alpha, abs=0.1)
    assert values["c_v1"] == 0.0
    assert "c_v1" not in [parameter.name for parameter in model.linear_parameters]
