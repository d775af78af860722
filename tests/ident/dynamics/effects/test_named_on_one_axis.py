"""Verdicts on one axis: an effect is named where it is, and nothing else in its place."""

from collections.abc import Callable

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building
from tests.running import first_fast

SEEDS = [pytest.param(seed, marks=[pytest.mark.slow] if seed else []) for seed in range(5)]
Law = Callable[[np.random.Generator], building.Torque]
"""Makes a torque from random numbers."""


def power(random: np.random.Generator) -> building.Torque:
    alpha = random.uniform(0.3, 0.75)
    return lambda motion: np.abs(motion.velocity) ** alpha * motion.direction


def weight(random: np.random.Generator) -> building.Torque:
    phase = random.uniform(0.0, 2 * np.pi)
    return lambda motion: np.sin(motion.position + phase)


def rubbing(random: np.random.Generator) -> building.Torque:
    wave, phase = random.uniform((1.0, 0.0), (3.0, 2 * np.pi))
    return lambda motion: np.sin(wave * motion.position + phase) * motion.direction


FIRST: dict[str, Law] = {
    "axis_weight": weight,
    "power_law_friction": power,
    "position_dependent_friction": rubbing,
    "quadratic_friction": lambda random: lambda motion: motion.velocity * np.abs(motion.velocity),
}
CURVES: dict[str, building.Torque] = {
    "stop of rubber": lambda motion: np.maximum(motion.position - 0.2, 0.0) ** 2,
    "cable": lambda motion: np.exp(motion.position / 0.3),
    # A bump half as wide needs more than nine knots: slow ripple is then named beside the curve.
    "bent guide": lambda motion: np.exp(-(((motion.position + 0.2) / 0.8) ** 2)),
}
SINGLES: dict[str, building.Torque] = {
    "joint_spring": lambda motion: motion.position - 0.2,
    "torque_offset": lambda motion: np.ones_like(motion.position),
    "axis_weight": lambda motion: np.sin(motion.position + 0.4),
}


def named(torque: building.Torque | None, seed: int, **motion: float) -> list[tuple[str, ...]]:
    """Effects that are found where an axis has an additional `torque`, each with those that may be meant."""
    return building.named(
        *(
            building.record(noise=0.05, seed=2 * seed + i, shape=shape, extra=torque, name=f"motion {i}", **motion)
            for i, shape in enumerate((seed, seed + 1000))
        )
    )


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", first_fast(FIRST))
def test_an_effect_is_named_first(effect: str, seed: int) -> None:
    law = FIRST[effect](np.random.default_rng(seed))
    torque = building.of_size(law, 0.03, shape=seed)

    def extra(motion: Motion) -> Floats:
        # A power of the speed takes the place of the viscous friction.
        in_place = building.VISCOUS * motion.velocity if effect == "power_law_friction" else 0.0
        return torque(motion) - in_place

    assert named(extra, seed)[0][0] == effect


@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_named_where_nothing_is_missing(seed: int) -> None:
    assert named(None, seed) == []


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("curve", first_fast(CURVES))
def test_a_curve_over_the_position_is_named_alone_where_no_single_effect_has_its_shape(curve: str, seed: int) -> None:
    found = named(building.of_size(CURVES[curve], 0.1, shape=seed), seed)
    assert [names[0] for names in found] == ["position_torque"]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", first_fast(SINGLES))
def test_a_curve_is_not_named_where_a_single_effect_will_do(effect: str, seed: int) -> None:
    (found,) = named(building.of_size(SINGLES[effect], 0.1, shape=seed), seed)
    assert found[0] != "position_torque"


def test_a_spring_may_be_a_weight_where_the_travel_is_short() -> None:
    spring = building.of_size(lambda motion: motion.position - 0.3, 0.03, size=0.15)
    assert set(named(spring, 0, size=0.15)[0]) == {"joint_spring", "axis_weight"}
