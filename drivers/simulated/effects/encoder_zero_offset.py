"""Zero offset of the encoder."""

from drivers.simulated.effect import HiddenEffect, parameter


class EncoderZeroOffset(HiddenEffect):
    """The encoder reads q + c: a wrong zero reference or a slipped coupling."""

    variables = ("position",)

    c: float = parameter(0.01, "rad", "reading minus true angle", ge=-0.3, le=0.3)

    def encoder(self, q: float) -> tuple[float, float]:
        return self.c, 0.0
