"""A load that is picked up during the run."""

from typing import ClassVar, Self

import numpy as np

from drivers.simulated.effect import Effect, parameter


class PayloadChange(Effect):
    """The platform's mass changes by dm at the time t_c; the load joins with the platform's velocity."""

    whole_robot: ClassVar[bool] = True

    dm: float = parameter(0.2, "kg", "mass picked up", ge=0, le=3)
    t_c: float = parameter(5.0, "s", "when, on the machine's clock", ge=0, le=1e6)

    @classmethod
    def draw_shape(cls, rng: np.random.Generator) -> dict[str, float]:
        return {"t_c": rng.uniform(7.0, 17.0)}

    def at(self, t: float) -> Self:
        return self.model_copy(update={"t_c": t})

    def added_mass(self, t: float) -> float:
        return self.dm if t >= self.t_c else 0.0
