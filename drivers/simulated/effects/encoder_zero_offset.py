"""Zero offset of the encoder."""

import numpy as np

from drivers.simulated.effect import HiddenEffect, draw_sign, parameter


class EncoderZeroOffset(HiddenEffect):
    """The encoder reads q + c: a wrong zero reference or a slipped coupling."""

    variables = ("position",)

    c: float = parameter(0.01, "rad", "reading minus true angle", ge=-0.3, le=0.3)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"c": draw_sign(rng, 0.01)}

    def encoder(self, q: float) -> tuple[float, float]:
        return self.c, 0.0
