"""Errors of the lengths in the rig file."""

from collections.abc import Mapping

import numpy as np

from drivers.simulated.effect import HiddenEffect, parameter
from recordings.rig import Geometry


class GeometryError(HiddenEffect):
    """Each length is the rig's plus `error` times its share. Only the difference of R and r has an effect."""

    variables = ("position", "velocity", "acceleration")
    whole_robot = True

    error: float = parameter(0.01, "m", "true length minus the rig's", ge=-0.1, le=0.1)
    L1: float = parameter(0.0, "1", "share of the arms in the error", ge=-1, le=1)
    L2: float = parameter(1.0, "1", "share of the rods", ge=-1, le=1)
    R: float = parameter(0.0, "1", "share of the base radius", ge=-1, le=1)
    r: float = parameter(0.0, "1", "share of the platform radius", ge=-1, le=1)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        length = str(rng.choice(_LENGTHS))
        return super().draw_shape(rng) | {name: float(name == length) for name in _LENGTHS}

    def geometry(self, geometry: Geometry) -> Geometry:
        lengths = {name: getattr(geometry, name) + self.error * getattr(self, name) for name in _LENGTHS}
        return geometry.model_copy(update=lengths)

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        shares = self.L1, self.L2, self.R - self.r
        largest = max(range(len(shares)), key=lambda which: abs(shares[which]))
        return {"e": self.error * shares[round(found.get("which", largest))], "which": largest}


_LENGTHS = ("L1", "L2", "R", "r")
