"""Hidden effects drawn by lot: effect, size, joints and shape."""

import math
from collections.abc import Sequence

import numpy as np

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build, library
from drivers.simulated.sizing import EffectSizer
from recordings.errors import BadInput
from recordings.rig import Rig

SMALLEST, LARGEST = 0.005, 0.10
"""Share of the torque that the base model cannot absorb."""
_CLOSE = 0.1
"""How far a size may miss what was wanted, relative."""
_DRAWS = 12


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
    """Different effects, each sized alone on the machine of `config` along fig5a; the same for the same seed.

    Takes a second or two for each. What cannot have its size on this robot with the joints and shape drawn is drawn
    again.

    Args:
        names: from which to draw; None: the library.
        sizes: one per effect to hide, so that () hides nothing; None: drawn between SMALLEST and LARGEST.
        joints: on which all of them act that have joints of their own; None: drawn.
        ruler: one made for this machine before, to save time.

    Raises:
        BadInput: an unknown name, too few names, or nothing that can be had was drawn.
    """
    rng = np.random.default_rng(seed)
    left = sorted(library() if names is None else names)
    if len(left) < len(sizes):
        raise BadInput(f"at least {len(sizes)} effects to draw from expected, {len(left)} found; name more")
    for name in left:
        build(EffectSpec(name=name))
    sizer = sizer or EffectSizer(rig, config)
    found: list[EffectSpec] = []
    for size in sizes:
        effect = _draw_sized(rng, sizer, left, size, joints)
        left.remove(effect.name)
        found.append(effect)
    return tuple(found)


def _draw_sized(
    rng: np.random.Generator, ruler: EffectSizer, names: Sequence[str], size: float | None, joints: Sequence[int] | None
) -> EffectSpec:
    for _ in range(_DRAWS):
        effect = draw_effect(rng, names, joints)
        wanted = math.exp(rng.uniform(math.log(SMALLEST), math.log(LARGEST))) if size is None else size
        found, reached = ruler.nearest(effect, wanted)
        enough = reached >= (1 - _CLOSE) * (SMALLEST if size is None else size)
        if enough and reached <= (1 + _CLOSE) * wanted:
            return found.spec()
    raise BadInput(f"a size that one of {', '.join(names)} can have on this robot expected, {wanted:g} found")


def draw_effect(
    rng: np.random.Generator, names: Sequence[str] | None = None, joints: Sequence[int] | None = None
) -> HiddenEffect:
    """An effect with joints and shape as they might be found; of its strength only the sign means something.

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
