"""Properties of all hidden effects that are discovered."""

import importlib
import inspect

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, SimConfig
from drivers.simulated.effect import HiddenEffect, build, discover, library, out_of_library, overrides
from drivers.simulated.machine import SimulatedMachine
from ident.dynamics.effects.library import library as candidates
from recordings.errors import BadInput
from recordings.rig import simulated_rig

LISTED = {
    "stribeck",
    "torque_offset",
    "asymmetric_viscous",
    "quadratic_friction",
    "load_dependent_friction",
    "presliding_hysteresis",
    "backlash",
    "joint_elasticity",
    "cogging",
    "joint_spring",
    "base_tilt",
    "payload_change",
    "rod_inertia",
    "arm_com_offset",
    "arm_mass_mismatch",
    "air_drag",
    "thermal_drift",
    "actuation_delay",
    "back_emf",
    "torque_gain_mismatch",
    "torque_map_exponent",
    "amplifier_deadband",
    "amplifier_saturation",
    "encoder_zero_offset",
    "encoder_eccentricity",
    "geometry_error",
    "power_law_friction",
    "position_dependent_friction",
    "position_torque",
}
"""Names that the diagnosis uses as well."""

ALWAYS_THERE = {"rod_inertia"}
"""Physics that the plant always includes."""
HOOKS = [
    "torque",
    "friction",
    "bristle",
    "added_mass",
    "drag",
    "tilt",
    "geometry",
    "arm",
    "couplings",
    "lag",
    "amplify",
    "back_emf",
    "gain",
    "exponent",
    "encoder",
]
VARIABLES = {"position", "velocity", "acceleration", "load", "time", "frequency", "joint_1", "joint_2", "joint_3"}
every = pytest.mark.parametrize("kind", [pytest.param(kind, id=name) for name, kind in sorted(discover().items())])


def test_library_is_the_list_of_effects() -> None:
    assert set(library()) == LISTED - ALWAYS_THERE


def test_some_effects_are_out_of_the_library() -> None:
    assert len(out_of_library()) >= 3
    assert not set(out_of_library()) & LISTED
    assert set(out_of_library()) | set(library()) == set(discover())


@every
def test_dependences_are_known_variables(kind: type[HiddenEffect]) -> None:
    assert set(kind().depends_on()) <= VARIABLES
    assert kind().depends_on() or kind.name() == "torque_offset"


def test_effect_between_joints_depends_on_them() -> None:
    assert discover()["hose_drag"](joints=(1, 3)).depends_on() == ("velocity", "joint_1", "joint_3")


@every
def test_no_size_is_drawn_that_a_diagnosis_holds_for_impossible(kind: type[HiddenEffect]) -> None:
    candidate = candidates(()).get(kind.name())
    if candidate and candidate.max_amplitude:
        assert kind.largest() <= candidate.max_amplitude


@every
def test_drawn_joints_are_valid(kind: type[HiddenEffect]) -> None:
    rng = np.random.default_rng(2)
    for _ in range(10):
        build(EffectSpec(name=kind.name(), joints=kind.draw_joints(rng)))


@every
def test_is_documented(kind: type[HiddenEffect]) -> None:
    assert inspect.getdoc(importlib.import_module(kind.__module__))
    assert kind.__doc__
    assert kind.__doc__ != HiddenEffect.__doc__


@every
def test_parameters_have_meaning_unit_and_bounds(kind: type[HiddenEffect]) -> None:
    parameters = {name: field for name, field in kind.model_fields.items() if name != "joints"}
    for field in parameters.values():
        assert field.description
        assert isinstance(field.json_schema_extra, dict)
        assert field.json_schema_extra["unit"]
    for name in parameters:
        with pytest.raises(BadInput, match=f"effect {kind.name()}: '{name}'"):
            build(EffectSpec(name=kind.name(), parameters={name: 1e9}))


@every
def test_overrides_a_hook(kind: type[HiddenEffect]) -> None:
    assert any(overrides(kind(), hook) for hook in HOOKS)
    assert not any(overrides(HiddenEffect(), hook) for hook in HOOKS)


@every
def test_effect_is_rebuilt_from_its_spec(kind: type[HiddenEffect]) -> None:
    effect = build(EffectSpec(name=kind.name(), parameters=kind.draw_shape(np.random.default_rng(5))))
    assert build(effect.spec()) == effect


@every
def test_zero_strength_equals_the_machine_without_effects(kind: type[HiddenEffect]) -> None:
    assert _moved(kind().scaled(0.0)) == pytest.approx(_moved(), abs=1e-9)


@every
def test_default_strength_changes_the_machine(kind: type[HiddenEffect]) -> None:
    assert _moved(kind().at(0.05)) != pytest.approx(_moved(), abs=1e-6)


def test_machine_runs_with_all_effects() -> None:
    assert np.all(np.abs(_moved(*(kind() for kind in discover().values()))) < 20.0)


def _moved(*effects: HiddenEffect) -> list[float]:
    """Positions and torques after a motion of 0.2 s without load reversal."""
    config = SimConfig(effects=tuple(effect.spec() for effect in effects))
    machine = SimulatedMachine(simulated_rig(), config, np.random.default_rng(0))
    machine.enabled, machine.brake = [True] * 3, [False] * 3
    start = np.array(machine.position())
    ease = 0.5 - 0.5 * np.cos(np.linspace(0.0, 3.0, 1000))
    machine.advance((start + ease[:, None] * np.array([0.2, 0.1, -0.1])).tolist())
    return machine.position() + machine.reported_torque()


@pytest.mark.parametrize(
    ("spec", "complaint"),
    [
        (EffectSpec(name="stribek"), "stribeck.*'stribek' found"),
        (EffectSpec(name="stribeck", parameters={"vs": 1.0}), "unknown key 'vs'"),
        (EffectSpec(name="stribeck", parameters={"a": -1.0}), "'a'"),
        (EffectSpec(name="base_tilt", joints=(1,)), "whole robot"),
        (EffectSpec(name="cogging", joints=()), "joints"),
        (EffectSpec(name="cogging", joints=(2, 2)), "joints"),
        (EffectSpec(name="hose_drag", joints=(2,)), r"two or three expected, \[2\] found"),
    ],
)
def test_bad_effect_is_explained(spec: EffectSpec, complaint: str) -> None:
    with pytest.raises(BadInput, match=complaint):
        build(spec)


def test_machine_refuses_unresolved_sizes() -> None:
    config = SimConfig(effects=(EffectSpec(name="cogging", size=0.02),))
    with pytest.raises(BadInput, match="size"):
        SimulatedMachine(simulated_rig(), config, np.random.default_rng(0))
