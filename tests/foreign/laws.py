"""Torque laws of the effects by the list of effects; couplings and sensors are in other modules."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numba import njit

from recordings.recording import Floats

Parameters = Mapping[str, float]
_TINY = 1e-300


@dataclass(frozen=True, eq=False)
class State:
    """State of the machine at all instants."""

    t: Floats
    """(n, 1) time [s]."""
    q: Floats
    """(n, 3) motor angles [rad]."""
    v: Floats
    a: Floats
    load: Floats
    """(n, 3) torque of the rigid robot [N m]."""
    coulomb: Floats
    """(3,) Coulomb friction levels [N m]."""
    viscous: Floats
    """(3,) viscous friction [N m s/rad]."""

    @property
    def direction(self) -> Floats:
        """(n, 3) sgn v."""
        sign: Floats = np.sign(self.v)
        return sign


Law = Callable[[State, Parameters], Floats]


def _presliding(s: State, p: Parameters) -> Floats:
    """c_c (z/z_s - sgn v)."""
    if p["z_s"] <= 0:
        return np.zeros_like(s.q)
    deflection = np.column_stack([bristle(np.ascontiguousarray(q), p["z_s"]) for q in s.q.T])
    return s.coulomb * (deflection - s.direction)


@njit(cache=True)
def bristle(q: Floats, z_s: float) -> Floats:
    """z / z_s (n,) along q: z' = v - |v| z / z_s, by Heun's rule in the displacement."""
    result = np.zeros(len(q))
    z = 0.0
    for k in range(1, len(q)):
        # Long steps are divided: the rule is stable up to a displacement of 2 z_s.
        substeps = int(abs(q[k] - q[k - 1]) / (0.05 * z_s)) + 1
        dq = (q[k] - q[k - 1]) / substeps
        for _ in range(substeps):
            first = dq - abs(dq) * z / z_s
            z += 0.5 * (first + dq - abs(dq) * (z + first) / z_s)
        result[k] = z / z_s
    return result


def _thermal(s: State, p: Parameters) -> Floats:
    """(a v + b sgn v) exp(-t/T), a = b times the viscous share."""
    return p["b"] * (p["viscous"] * s.v + s.direction) * np.exp(-s.t / p["T"])


def _self_heating(s: State, p: Parameters) -> Floats:
    """Friction times -fall h, T h' = P / mean P - h: h is the mean of P over the past, weighted by exp(t/T)."""
    friction = s.viscous * s.v + s.coulomb * s.direction
    power = friction * s.v
    weight = np.exp(s.t / p["T"])
    past = np.cumsum(weight * power / power.mean(axis=0), axis=0) * (s.t[1] - s.t[0]) / p["T"]
    return -p["fall"] * past / weight * friction


def _directional(s: State, p: Parameters) -> Floats:
    """a_d |load| where the power goes from motor to load, a_b |load| where it comes back."""
    share = np.where(s.load * s.v > 0, p["a_d"], p["a_d"] * p["back"])
    return share * np.abs(s.load) * s.direction


MOTOR: dict[str, Law] = {
    "torque_offset": lambda s, p: np.full_like(s.q, p["a"]),
    "asymmetric_viscous": lambda s, p: p["a"] * np.abs(s.v),
    "quadratic_friction": lambda s, p: p["a"] * s.v * np.abs(s.v),
    "stribeck": lambda s, p: p["a"] * np.exp(-((s.v / p["v_s"]) ** 2)) * s.direction,
    "power_law_friction": lambda s, p: (
        p["c"] * s.direction * np.exp(p["alpha"] * np.log(np.abs(s.v) + _TINY)) - s.viscous * s.v
    ),
    "position_dependent_friction": lambda s, p: (
        2 * p["a"] * ((1 + np.sin(p["k"] * s.q + p["phase"])) / 2) ** p["p"] * s.direction
    ),
    "load_dependent_friction": lambda s, p: p["a"] * np.abs(s.load) * s.direction,
    "directional_load_friction": _directional,
    "stribeck_load_friction": lambda s, p: p["a"] * np.abs(s.load) * np.exp(-((s.v / p["v_s"]) ** 2)) * s.direction,
    "self_heating": _self_heating,
    "cogging": lambda s, p: p["a"] * np.sin(p["N"] * s.q + p["phase"]),
    "joint_spring": lambda s, p: p["k"] * (s.q - p["q_0"]),
    "thermal_drift": _thermal,
    "presliding_hysteresis": _presliding,
    "uneven_grease": lambda s, p: p["a"] * np.sin(2 * s.q + p["phase"]) * s.v,
    "creeping_zero": lambda s, p: p["a"] * (1 - np.exp(-s.t / p["T"])) * np.ones(3),
    "fan": lambda s, p: p["a"] * np.sin(2 * np.pi * p["f"] * s.t + p["phase"]) * np.ones(3),
    "bearing_load": lambda s, p: p["a"] * np.abs(s.a) * s.direction,
    "position_torque": lambda s, p: p["a"] * np.maximum(s.q - p["q_0"], 0.0) ** p["p"],
}
"""Additional motor torque (n, 3) of effects on the motor side of the coupling."""

ARM: dict[str, Law] = {
    "arm_com_offset": lambda s, p: p["a"] * np.sin(s.q),
    "arm_mass_mismatch": lambda s, p: p["a"] * np.cos(s.q),
}
"""Additional torque (n, 3) of effects on the arm side of the coupling."""
