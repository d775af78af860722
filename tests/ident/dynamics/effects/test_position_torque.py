"""Torque that is a curve over the position of one axis."""

import numpy as np
import pytest

from tests.ident import building

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


def named(torque: building.Torque, seed: int, share: float) -> list[str]:
    """Effects that are found where an axis has a `torque` of this share of its own."""
    extra = building.of_size(torque, share, shape=seed)
    train, validate = (
        building.record(noise=0.05, seed=2 * seed + i, shape=shape, extra=extra, name=f"motion {i}")
        for i, shape in enumerate((seed, seed + 1000))
    )
    return [names[0] for names in building.named(train, validate)]


SEEDS = [pytest.param(seed, marks=[] if seed in (0, 2) else [pytest.mark.slow]) for seed in range(5)]
"""With seed 2, held-out rows lie beyond the trained travel, where a curve is not judged: it has to rank first yet."""


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("curve", CURVES)
def test_is_named_alone_where_no_single_effect_has_the_shape(curve: str, seed: int) -> None:
    assert named(CURVES[curve], seed, 0.1) == ["position_torque"]


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("effect", SINGLES)
def test_is_not_named_where_a_single_effect_will_do(effect: str, seed: int) -> None:
    found = named(SINGLES[effect], seed, 0.1)
    assert len(found) == 1
    assert found != ["position_torque"]
