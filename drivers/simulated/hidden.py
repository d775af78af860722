"""Random hidden effects: effect, size, joints and shape."""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build, discover, library
from drivers.simulated.sizing import EffectSizer
from recordings.errors import BadInput
from recordings.rig import Rig

SMALLEST, LARGEST = 0.005, 0.10
"""Bounds of the sizes: unexplained residual over torque."""
_SIZE_TOLERANCE = 0.1
"""Tolerance of a size, relative to the one requested."""
_MAX_DRAWS = 12


def draw(
    seed: int,
    rig: Rig,
    config: SimConfig,
    *,
    names: Sequence[str] | None = None,
    sizes: Sequence[float | None] = (None,),
    joints: Sequence[int] | None = None,
    sizer: EffectSizer | None = None,
) -> tuple[EffectSpec, ...]:
    """Draw different effects, each sized alone on the machine of `config` along fig5a; reproducible by the seed.

    Takes one or two seconds for each. An effect that cannot have its size on this robot with the joints and shape
    drawn is drawn again.

    Args:
        names: effects to draw from; None: those of the library that a seed draws.
        sizes: one per effect to hide; () hides nothing. None: drawn between SMALLEST and LARGEST.
        joints: of all effects that do not act on the whole robot; None: drawn.
        sizer: an existing one for this machine, to save time.

    Raises:
        BadInput: an unknown name, too few names, or no effect that can have its size was drawn.
    """
    rng = np.random.default_rng(seed)
    drawn_by_seed = [name for name, kind in discover().items() if kind.in_library() and kind.drawn_by_seed]
    candidates = sorted(drawn_by_seed if names is None else names)
    if len(candidates) < len(sizes):
        raise BadInput(f"at least {len(sizes)} effects to draw from expected, {len(candidates)} found; name more")
    for name in candidates:
        build(EffectSpec(name=name))
    sizer = sizer or EffectSizer(rig, config)
    result: list[EffectSpec] = []
    for size in sizes:
        effect = _draw_sized(rng, sizer, candidates, size, joints)
        candidates.remove(effect.name)
        result.append(effect)
    return tuple(result)


def _draw_sized(
    rng: np.random.Generator,
    sizer: EffectSizer,
    names: Sequence[str],
    size: float | None,
    joints: Sequence[int] | None,
) -> EffectSpec:
    for _ in range(_MAX_DRAWS):
        effect = draw_effect(rng, names, joints)
        target_size = math.exp(rng.uniform(math.log(SMALLEST), math.log(LARGEST))) if size is None else size
        result, reached = sizer.nearest(effect, target_size)
        enough = reached >= (1 - _SIZE_TOLERANCE) * (SMALLEST if size is None else size)
        if enough and reached <= (1 + _SIZE_TOLERANCE) * target_size:
            return result.spec()
    raise BadInput(f"a size that one of {', '.join(names)} can have on this robot expected, {target_size:g} found")


def draw_effect(
    rng: np.random.Generator, names: Sequence[str] | None = None, joints: Sequence[int] | None = None
) -> HiddenEffect:
    """Draw an effect with realistic joints and shape; only the sign of its strength is meaningful.

    `names` and `joints` as for `draw`.

    Raises:
        BadInput: an unknown name, or joints that do not fit the effect.
    """
    names = list(library() if names is None else names)
    name = names[int(rng.integers(len(names)))]
    kind = type(build(EffectSpec(name=name)))
    drawn = kind.draw_joints(rng)
    if joints is not None and not kind.whole_robot:
        drawn = tuple(joints)
    return build(EffectSpec(name=name, joints=drawn, parameters=kind.draw_shape(rng)))
