"""Laws that no effect of the list contains: what a formula is searched for.

Beside those in `out_of_library`, which the locked cases of `benchmarks.hidden_effects` are drawn from.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from pydantic import create_model

from drivers.simulated.effect import HiddenEffect, parameter
from recordings.recording import Floats
from tests.foreign.laws import Parameters, State

Law = Callable[[State, State, Parameters], Floats]
"""Additional motor torque (n, 3) of each joint by its own state, the state of the other joint, and parameters."""


class OfPair(HiddenEffect):
    """An effect between two joints, on both."""

    between_joints = True


class OfOther(HiddenEffect):
    """An effect of another joint's motion on one joint."""

    single_joint = True


_AHEAD = parameter(1.0, "1", "whole part: how many joints further the other one is", ge=1, le=3, drawn=(1.0, 3.0))
_PHASE = parameter(0.0, "rad", "at angle zero", ge=-np.pi, le=np.pi, drawn=(-np.pi, np.pi))
_ORDER = parameter(20.0, "1/turn", "periods per turn of the joint", ge=1, le=100, drawn=(6.0, 25.0))
_SPEED = parameter(1.0, "rad/s", "characteristic speed", ge=0.01, le=50, drawn=(0.4, 1.5))
_FIELDS: dict[str, tuple[type[HiddenEffect], dict[str, Any]]] = {
    "spring_and_damper": (
        OfPair,
        {
            "k": parameter(1.0, "N m/rad", "stiffness", ge=0, le=50),
            "T": parameter(0.2, "s", "damping over stiffness", ge=0, le=5, drawn=(0.1, 0.4)),
        },
    ),
    "mutual_inertia": (OfPair, {"J": parameter(0.01, "kg m^2", "mutual inertia", ge=0, le=2)}),
    "friction_of_other": (
        OfOther,
        {"a": parameter(0.3, "N m", "largest change", ge=0, le=20), "phase": _PHASE, "ahead": _AHEAD},
    ),
    "far_damper": (
        HiddenEffect,
        {
            "c": parameter(1.0, "N m s/rad^2", "damping per angle", ge=0, le=100),
            "q_0": parameter(-0.2, "rad", "where it engages", ge=-1.5, le=1.5, drawn=(-0.3, 0.0)),
        },
    ),
    "eddy_brake": (HiddenEffect, {"b": parameter(0.3, "N m s/rad", "at low speed", ge=0, le=50), "v": _SPEED}),
    "sigmoid": (HiddenEffect, {"a": parameter(0.3, "N m", "at high speed", ge=0, le=50), "v": _SPEED}),
    "shaking_by_other": (
        OfOther,
        {"a": parameter(0.3, "N m", "amplitude", ge=0, le=20), "N": _ORDER, "phase": _PHASE, "ahead": _AHEAD},
    ),
    "loaded_ripple": (
        HiddenEffect,
        {"a": parameter(0.05, "1", "amplitude over load", ge=0, le=1), "N": _ORDER, "phase": _PHASE},
    ),
}
KINDS: dict[str, type[HiddenEffect]] = {
    name: create_model(name, __base__=base, **{key: (float, field) for key, field in fields.items()})  # type: ignore[call-overload]
    for name, (base, fields) in _FIELDS.items()
}
"""The effects of this module."""
LAWS: dict[str, Law] = {
    "tangled_cables": lambda s, other, p: p["k"] * (s.q - other.q),
    "spring_and_damper": lambda s, other, p: p["k"] * (s.q - other.q + p["T"] * (s.v - other.v)),
    "mutual_inertia": lambda s, other, p: p["J"] * other.a,
    "friction_of_other": lambda s, other, p: p["a"] * np.sin(2 * other.q + p["phase"]) * s.direction,
    "far_damper": lambda s, other, p: p["c"] * np.maximum(s.q - p["q_0"], 0.0) * s.v,
    "eddy_brake": lambda s, other, p: p["b"] * s.v / (1 + (s.v / p["v"]) ** 2),
    "sigmoid": lambda s, other, p: p["a"] * np.tanh(s.v / p["v"]),
    "shaking_by_other": lambda s, other, p: p["a"] * np.sin(p["N"] * other.q + p["phase"]),
    "loaded_ripple": lambda s, other, p: p["a"] * s.load * np.sin(p["N"] * s.q + p["phase"]),
}


def others(effect: HiddenEffect) -> list[int]:
    """The joint (from 0), for each of the three, whose motion acts on it."""
    if "ahead" in type(effect).model_fields:
        return [(joint + int(effect.model_dump()["ahead"])) % 3 for joint in range(3)]
    pair = [joint - 1 for joint in effect.joints] if effect.between_joints else []
    return [sum(pair[:2]) - joint if joint in pair[:2] else joint for joint in range(3)]


def torque(name: str, effect: HiddenEffect, s: State) -> Floats:
    """(n, 3) torque by the law `name` with the parameters of `effect`, on all joints alike."""
    order = others(effect)
    other = replace(s, q=s.q[:, order], v=s.v[:, order], a=s.a[:, order])
    return LAWS[name](s, other, effect.model_dump())
