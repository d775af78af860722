"""The size of an effect in words: the values of its parameters, as its own file puts them."""

from dataclasses import dataclass

import numpy as np

from ident.dynamics.effects.base import Effect, is_infinite
from recordings.recording import Floats
from recordings.rig import Rig

_MOST_LISTED = 3
"""Parameters that are listed of an effect that does not say how; of more, the largest value is said."""


@dataclass(frozen=True)
class ValueRange:
    """The values (instances,) of one quantity: in a text `{a}`, or without its unit `{a:n}` or `{a:%}`."""

    values: Floats
    unit: str

    def __format__(self, spec: str) -> str:
        """Two digits with the unit; three digits without it; or percent."""
        if is_infinite(float(self.values[0]), self.unit):
            return "never"
        unit = "%" if spec == "%" else "" if spec == "n" or self.unit == "1" else self.unit
        scaled, digits = self.values * (100 if spec == "%" else 1), 3 if spec == "n" else 2
        ends = dict.fromkeys(
            f"{end:.0f}" if abs(end) >= 10**digits else f"{end:.{digits}g}" for end in (scaled.min(), scaled.max())
        )
        return f"{' to '.join(ends)} {unit}".rstrip()


def size_in_words(effect: Effect, rig: Rig, joint: int, local: Floats, shapes: Floats) -> str:
    """The size of `effect` on joints with the units of `joint` (from 0) of `rig`, as `Effect.size` puts it.

    local: (instances, c) parameters; shapes: (instances, s), or (1, s) where they are shared.
    """
    pairs = [*zip(effect.parameters, local.T, strict=True), *zip(effect.shapes, shapes.T, strict=True)]
    spans = {quantity.name: ValueRange(values, quantity.unit_on(rig, joint)) for quantity, values in pairs}
    first = spans[effect.parameters[0].name].unit
    listed = ", ".join(f"{name} = {{{name}}}" for name in spans) if len(spans) <= _MOST_LISTED else "up to {largest}"
    return (effect.size or listed).format(
        **spans,
        norm=ValueRange(np.linalg.norm(local, axis=1), first),
        largest=ValueRange(np.array([np.abs(local).max()]), first),
        turn="turn" if rig.position_units[joint] == "rad" else "2π m",
    )
