"""Effects outside of the library, different from those of the simulated rig: parameters and variables."""

import math

from drivers.simulated.effect import HiddenEffect, parameter


class UnevenGrease(HiddenEffect):
    """Viscous friction that depends on the angle: a sin(2 q + phase) v."""

    variables = ("position", "velocity")

    a: float = parameter(0.2, "N m s/rad", "half of what the coefficients differ by", ge=0, le=5)
    phase: float = parameter(0.0, "rad", "at joint angle zero", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi))


class CreepingZero(HiddenEffect):
    """Drift of the amplifier's zero: a (1 - exp(-t / T))."""

    variables = ("time",)

    a: float = parameter(0.3, "N m", "torque in the end", ge=-10, le=10)
    T: float = parameter(10.0, "s", "time constant", ge=0.1, le=1e3, drawn=(4.0, 15.0))


class Fan(HiddenEffect):
    """Vibration of constant frequency: a sin(2 pi f t + phase)."""

    variables = ("frequency",)

    a: float = parameter(0.3, "N m", "amplitude", ge=0, le=5)
    f: float = parameter(9.3, "Hz", "frequency", ge=0.1, le=200, drawn=(4.0, 20.0))
    phase: float = parameter(0.0, "rad", "at the beginning", ge=-math.pi, le=math.pi, drawn=(-math.pi, math.pi))


class TangledCables(HiddenEffect):
    """A cable between two arms: k (q_i - q_j)."""

    variables = ("position",)
    between_joints = True

    k: float = parameter(1.0, "N m/rad", "stiffness", ge=0, le=20)


class BearingLoad(HiddenEffect):
    """Dry friction that grows with the acceleration, which loads the bearings: a |v'| sgn v."""

    variables = ("velocity", "acceleration")

    a: float = parameter(0.02, "N m s^2/rad", "dry friction per acceleration", ge=0, le=2)


KINDS: dict[str, type[HiddenEffect]] = {
    "uneven_grease": UnevenGrease,
    "creeping_zero": CreepingZero,
    "fan": Fan,
    "tangled_cables": TangledCables,
    "bearing_load": BearingLoad,
}
