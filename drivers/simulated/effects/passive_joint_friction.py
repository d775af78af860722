"""Friction of the balls at the ends of the rods."""

from collections.abc import Mapping

from drivers.simulated.effect import HiddenEffect, parameter


class PassiveJointFriction(HiddenEffect):
    """The balls at both ends of each rod rub with mu + c w, c = mu `viscous`, at the angular velocity w."""

    variables = ("velocity", "position")
    whole_robot = True
    drawn_by_seed = False

    mu: float = parameter(0.2, "N m", "dry friction of the balls at one end of a limb's rods", ge=0, le=10)
    viscous: float = parameter(0.05, "s/rad", "c / mu, viscous friction over dry", ge=0, le=1, drawn=(0.0, 0.2))

    def ball_friction(self) -> tuple[float, float]:
        return self.mu, self.mu * self.viscous

    def identified(self, joint: int, coulomb: float, found: Mapping[str, float]) -> Mapping[str, float]:
        return dict(zip(("mu", "c"), self.ball_friction(), strict=True))
