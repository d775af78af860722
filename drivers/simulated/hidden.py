"""Hidden effects drawn by lot: effect, size, joints and shape."""

import math

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import Effect, build, discover
from drivers.simulated.sizing import Ruler
from recordings.rig import Rig

SMALLEST, LARGEST = 0.005, 0.10
"""Share of the torque that the base model cannot absorb."""


def draw(seed: int, rig: Rig, config: SimConfig) -> tuple[EffectSpec, ...]:
    """One effect, sized on the machine of `config` along fig5a; the same for the same seed. Takes seconds.

    An effect that stays below the smallest size on the joints drawn, however strong, is drawn again.
    """
    rng = np.random.default_rng(seed)
    ruler = Ruler(rig, config)
    while True:
        effect = draw_effect(rng)
        wanted = math.exp(rng.uniform(math.log(SMALLEST), math.log(LARGEST)))
        found, size = ruler.nearest(effect, wanted)
        if size >= 0.9 * SMALLEST:
            return (found.spec(),)


def draw_effect(rng: np.random.Generator) -> Effect:
    """An effect with joints and shape as they might be found; of its strength only the sign means something."""
    kinds = discover()
    kind = kinds[sorted(kinds)[rng.integers(len(kinds))]]
    shape = kind.draw_shape(rng)
    joints = (1, 2, 3) if kind.whole_robot else tuple(sorted((rng.permutation(3)[: rng.integers(1, 4)] + 1).tolist()))
    return build(EffectSpec(name=kind.name(), joints=joints, parameters=shape))
