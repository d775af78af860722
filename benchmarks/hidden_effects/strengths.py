"""Errors of the estimated strengths of hidden effects."""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from operator import itemgetter
from typing import Any

import numpy as np

Parameters = Mapping[str, float]

_GRAVITY = 9.81
_STRENGTH_PARAMETERS: dict[str, str] = {
    "stribeck": "a",
    "torque_offset": "a",
    "asymmetric_viscous": "a",
    "quadratic_friction": "a",
    "load_dependent_friction": "a",
    "directional_load_friction": "a_d",
    "stribeck_load_friction": "a",
    "passive_joint_friction": "mu",
    "power_law_friction": "c",
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
"""Strength parameter of each effect whose parameter has the same name in the plant and in `ident`."""


def _peak_to_peak(estimate: Parameters, knots: str) -> float:
    """Of a curve: its values are the parameters whose names begin with `knots`."""
    return float(np.ptp([value for name, value in estimate.items() if name.startswith(knots)]))


def _end_of_travel(true: Parameters, end: str) -> float:
    """Torque of a hidden `position_torque` at an end of the travel, "low" or "high", that the estimate tells."""
    return float(true["a"] * max(true[end] - true["q_0"], 0.0) ** true["p"])


_STRENGTH_FUNCTIONS: dict[str, tuple[Callable[[Parameters], float], Callable[[Parameters], float]]] = {
    "cogging": (lambda true: true["a"], lambda estimate: math.hypot(estimate["a"], estimate["b"])),
    "encoder_eccentricity": (lambda true: true["a"], lambda estimate: math.hypot(estimate["a"], estimate["b"])),
    "position_dependent_friction": (
        lambda true: true["a"],
        lambda estimate: _peak_to_peak(estimate, "f_") / 2,
    ),
    "position_torque": (
        lambda true: _end_of_travel(true, "high") - _end_of_travel(true, "low"),
        lambda estimate: _peak_to_peak(estimate, "g_"),
    ),
    "base_tilt": (
        lambda true: _GRAVITY * math.sin(true["angle"]),
        lambda estimate: math.hypot(estimate["g_x"], estimate["g_y"]),
    ),
    "self_heating": (lambda true: true["fall"], lambda estimate: -estimate["k"]),
    "actuation_delay": (lambda true: true["delay"], lambda estimate: estimate["delta"]),
    "torque_gain_mismatch": (lambda true: true["mismatch"], lambda estimate: estimate["e"]),
    "geometry_error": (lambda true: true["error"] * (-1 if true["r"] else 1), lambda estimate: estimate["e"]),
}
"""Strength from the parameters of the plant (and the travel), and from those of `ident`, of effects whose parameters
differ. The strength of a curve is its peak-to-peak value over the travel."""


def errors(truth: Iterable[Mapping[str, Any]], values: Parameters) -> dict[str, float]:
    """Relative error of the strength of each effect, the mean over its joints.

    truth: the hidden effects; values: parameters of the last model by name. Effects that the model does not contain
    are omitted.
    """
    relative_errors = {}
    for effect in truth:
        of_joints = list(_of_joints(effect, values))
        if of_joints:
            relative_errors[effect["name"]] = sum(of_joints) / len(of_joints)
    return relative_errors


def _of_joints(effect: Mapping[str, Any], values: Parameters) -> Iterator[float]:
    """Yield the relative error of the strength of a hidden `effect` on each joint where the model has it.

    A joint whose true strength is 0, as that of a curve that is flat over the travel, has no relative error.
    """
    name = effect["name"]
    for joint in effect["joints"]:
        estimate = _estimated_parameters(name, joint, values)
        if not estimate:
            continue
        of_plant, of_estimate = _STRENGTH_FUNCTIONS.get(name) or [itemgetter(_STRENGTH_PARAMETERS[name])] * 2
        if not (true := of_plant({**estimate, **effect["parameters"]})):
            continue
        try:
            yield abs(of_estimate(estimate) / true - 1)
        except KeyError:
            yield math.nan


def interval_coverage(
    truth: Iterable[Mapping[str, Any]], parameters: Mapping[str, Mapping[str, Any]]
) -> tuple[bool, ...]:
    """Whether the 95 % interval of each strength contains the true value.

    Only parameters with the same name in the plant and in `ident` are tested. truth: the hidden effects; parameters:
    those of the last model by name, as in the document of a diagnosis.
    """
    covered = []
    for effect in truth:
        name = _STRENGTH_PARAMETERS.get(effect["name"], "")
        for joint in ("", *map(str, effect["joints"])):
            limits = parameters.get(f"{effect['name']}.{name}{joint}", {}).get("ci95")
            if limits:
                covered.append(limits[0] <= effect["parameters"][name] <= limits[1])
    return tuple(covered)


def _estimated_parameters(effect: str, joint: int, values: Parameters) -> dict[str, float]:
    """Estimated parameters of an effect on a `joint` (from 1), including those shared by all joints."""
    effect_values = {
        name.removeprefix(f"{effect}."): value for name, value in values.items() if name.startswith(f"{effect}.")
    }
    on_joint = {name[:-1]: value for name, value in effect_values.items() if name.endswith(str(joint))}
    shared = {name: value for name, value in effect_values.items() if name[-1] not in "123"}
    strength_parameter = _STRENGTH_PARAMETERS.get(effect)
    parameters = shared | on_joint
    return parameters if strength_parameter is None or strength_parameter in parameters else {}
