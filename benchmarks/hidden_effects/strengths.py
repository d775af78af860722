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
    "cogging": (lambda true: true["a"], lambda estimate: math.hypot(estimate["a"], estimate["b"])),
    "encoder_eccentricity": (lambda true: true["a"], lambda estimate: math.hypot(estimate["a"], estimate["b"])),
    "base_tilt": (
        lambda true: _GRAVITY * math.sin(true["angle"]),
        lambda estimate: math.hypot(estimate["g_x"], estimate["g_y"]),
    ),
    "actuation_delay": (lambda true: true["delay"], lambda estimate: estimate["delta"]),
    "torque_gain_mismatch": (lambda true: true["mismatch"], lambda estimate: estimate["e"]),
    "geometry_error": (lambda true: true["error"] * (-1 if true["r"] else 1), lambda estimate: estimate["e"]),
}
"""Its strength by the parameters of the plant, and by those of `ident`, where they differ."""


def errors(truth: Iterable[Mapping[str, Any]], values: Parameters) -> dict[str, float]:
    """Effect: error of its strength relative to the truth, the mean over its joints.

    truth: the hidden effects; values: parameters of the last model by name. What the model lacks is left out.
    """
    relative_errors = {}
    for effect in truth:
        estimates = [_own(effect["name"], joint, values) for joint in effect["joints"]]
        strengths = [_strength(effect["name"], parameters) for parameters in estimates if parameters]
        if strengths:
            true = _true(effect["name"], effect["parameters"])
            relative_errors[effect["name"]] = sum(abs(strength / true - 1) for strength in strengths) / len(strengths)
    return relative_errors


def inside(truth: Iterable[Mapping[str, Any]], parameters: Mapping[str, Mapping[str, Any]]) -> tuple[bool, ...]:
    """Whether the 95 % interval of a strength holds the truth, of each that plant and `ident` call the same.

    truth: the hidden effects; parameters: of the last model by name, as in the document of a diagnosis.
    """
    covered = []
    for effect in truth:
        name = _SAME.get(effect["name"], "")
        for joint in ("", *map(str, effect["joints"])):
            limits = parameters.get(f"{effect['name']}.{name}{joint}", {}).get("ci95")
            if limits:
                covered.append(limits[0] <= effect["parameters"][name] <= limits[1])
    return tuple(covered)


def _own(effect: str, joint: int, values: Parameters) -> dict[str, float]:
    """What the model says of the effect on that joint (from 1): its parameters, those of the whole robot included."""
    mine = {name.removeprefix(f"{effect}."): value for name, value in values.items() if name.startswith(f"{effect}.")}
    on_joint = {name[:-1]: value for name, value in mine.items() if name.endswith(str(joint))}
    everywhere = {name: value for name, value in mine.items() if name[-1] not in "123"}
    needed = _SAME.get(effect)
    parameters = everywhere | on_joint
    return parameters if needed is None or needed in parameters else {}


def _strength(effect: str, estimate: Parameters) -> float:
    try:
        return estimate[_SAME[effect]] if effect in _SAME else _OTHER[effect][1](estimate)
    except KeyError:
        return math.nan


def _true(effect: str, parameters: Parameters) -> float:
    return parameters[_SAME[effect]] if effect in _SAME else _OTHER[effect][0](parameters)
