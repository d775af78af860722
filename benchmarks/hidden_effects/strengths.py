"""How far the strength of an effect was missed, where it was named."""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

Parameters = Mapping[str, float]

_GRAVITY = 9.81
_SAME: dict[str, str] = {
    "stribeck": "a",
    "torque_offset": "a",
    "asymmetric_viscous": "a",
    "quadratic_friction": "a",
    "load_dependent_friction": "a",
    "presliding_hysteresis": "z_s",
    "backlash": "b",
    "joint_elasticity": "compliance",
    "joint_spring": "k",
    "payload_change": "dm",
    "arm_com_offset": "a",
    "arm_mass_mismatch": "a",
    "air_drag": "c",
    "thermal_drift": "b",
    "back_emf": "k_e",
    "torque_map_exponent": "excess",
    "amplifier_deadband": "width",
    "amplifier_saturation": "inverse_level",
    "encoder_zero_offset": "c",
}
"""The parameter that is its strength, where plant and `ident` call it the same."""
_OTHER: dict[str, tuple[Callable[[Parameters], float], Callable[[Parameters], float]]] = {
    "cogging": (lambda true: true["a"], lambda own: math.hypot(own["a"], own["b"])),
    "encoder_eccentricity": (lambda true: true["a"], lambda own: math.hypot(own["a"], own["b"])),
    "base_tilt": (lambda true: _GRAVITY * math.sin(true["angle"]), lambda own: math.hypot(own["g_x"], own["g_y"])),
    "actuation_delay": (lambda true: true["delay"], lambda own: own["delta"]),
    "torque_gain_mismatch": (lambda true: true["mismatch"], lambda own: own["e"]),
    "geometry_error": (lambda true: true["error"] * (-1 if true["r"] else 1), lambda own: own["e"]),
}
"""Its strength by the parameters of the plant, and by those of `ident`, where they differ."""


def errors(truth: Iterable[Mapping[str, Any]], values: Parameters) -> dict[str, float]:
    """Effect: error of its strength relative to the truth, the mean over its joints.

    truth: the hidden effects; values: parameters of the last model by name. What the model lacks is left out.
    """
    found = {}
    for one in truth:
        own = [_own(one["name"], joint, values) for joint in one["joints"]]
        strengths = [_strength(one["name"], parameters) for parameters in own if parameters]
        if strengths:
            true = _true(one["name"], one["parameters"])
            found[one["name"]] = sum(abs(strength / true - 1) for strength in strengths) / len(strengths)
    return found


def inside(truth: Iterable[Mapping[str, Any]], parameters: Mapping[str, Mapping[str, Any]]) -> tuple[bool, ...]:
    """Whether the 95 % interval of a strength holds the truth, of each that plant and `ident` call the same.

    truth: the hidden effects; parameters: of the last model by name, as in the document of a diagnosis.
    """
    found = []
    for one in truth:
        name = _SAME.get(one["name"], "")
        for joint in ("", *map(str, one["joints"])):
            limits = parameters.get(f"{one['name']}.{name}{joint}", {}).get("ci95")
            if limits:
                found.append(limits[0] <= one["parameters"][name] <= limits[1])
    return tuple(found)


def _own(effect: str, joint: int, values: Parameters) -> dict[str, float]:
    """What the model says of the effect on that joint (from 1): its parameters, those of the whole robot included."""
    mine = {name.removeprefix(f"{effect}."): value for name, value in values.items() if name.startswith(f"{effect}.")}
    on_joint = {name[:-1]: value for name, value in mine.items() if name.endswith(str(joint))}
    everywhere = {name: value for name, value in mine.items() if name[-1] not in "123"}
    needed = _SAME.get(effect)
    parameters = everywhere | on_joint
    return parameters if needed is None or needed in parameters else {}


def _strength(effect: str, own: Parameters) -> float:
    try:
        return own[_SAME[effect]] if effect in _SAME else _OTHER[effect][1](own)
    except KeyError:
        return math.nan


def _true(effect: str, parameters: Parameters) -> float:
    return parameters[_SAME[effect]] if effect in _SAME else _OTHER[effect][0](parameters)
