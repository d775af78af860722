"""Hidden torques and friction, each compared with its law on the machine."""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, Friction, SimConfig
from drivers.simulated.machine import SimulatedMachine
from tests.drivers.simulated.swinging import RIG, Floats, Run, held_torque, machine_with, swing

COULOMB = 0.7


@pytest.mark.parametrize(
    ("name", "parameters", "law"),
    [
        ("torque_offset", {"a": 0.8}, lambda q: 0.8),
        ("joint_spring", {"k": 3.0, "q_0": 0.3}, lambda q: 3.0 * (q - 0.3)),
        ("cogging", {"a": 0.5, "N": 21.0, "phase": 0.4}, lambda q: 0.5 * math.sin(21.0 * q + 0.4)),
        ("arm_com_offset", {"a": -1.2}, lambda q: -1.2 * math.sin(q)),
        ("arm_mass_mismatch", {"a": 1.1}, lambda q: 1.1 * math.cos(q)),
    ],
)
def test_static_torque_of_joint_2(name: str, parameters: dict[str, float], law: Callable[[float], float]) -> None:
    bare, hidden = machine_with(), machine_with(name, **parameters)
    for turn in np.linspace(-0.15, 0.15, 5):
        theta = np.array(bare.position()) * 0 + np.array([0.2, 0.2 + turn, 0.2])
        difference = held_torque(hidden, theta) - held_torque(bare, theta)
        assert difference == pytest.approx([0.0, law(theta[1]), 0.0], abs=2e-3)


TORQUES: dict[str, tuple[dict[str, float], Callable[[Run], Floats]]] = {
    "asymmetric_viscous": ({"a": 0.4}, lambda r: 0.4 * np.abs(r.v[:, 1])),
    "quadratic_friction": ({"a": 0.3}, lambda r: 0.3 * r.v[:, 1] * np.abs(r.v[:, 1])),
    "pulsation": ({"a": 0.5, "f": 7.3, "phase": 0.6}, lambda r: 0.5 * np.sin(2 * np.pi * 7.3 * r.t + 0.6)),
    "position_torque": (
        {"a": 20.0, "q_0": -0.3, "p": 2.5},
        lambda r: 20.0 * np.maximum(r.q[:, 1] + 0.3, 0) ** 2.5,
    ),
    "hose_drag": ({"c": 0.3}, lambda r: 0.3 * (r.v[:, 1] - r.v[:, 0])),
    "rotor_coupling": ({"J": 0.02}, lambda r: 0.02 * r.a[:, 0]),
}
"""Laws of joint 2; effects between joints couple joints 1 and 2."""


@pytest.mark.parametrize("name", TORQUES)
def test_added_torque(name: str) -> None:
    parameters, law = TORQUES[name]
    run = swing(machine_with(name, **parameters))
    expected = law(run)
    assert np.std(expected) > 0.05
    assert run.added[:, 1] == pytest.approx(expected, abs=1e-6)
    assert np.abs(run.added[:, 2]).max() < 1e-6


@pytest.mark.parametrize("name", ["hose_drag", "rotor_coupling"])
def test_coupling_between_joints_is_symmetric(name: str) -> None:
    parameters, law = TORQUES[name]
    run = swing(machine_with(name, **parameters))
    order = [1, 0, 2]
    assert run.added[:, 0] == pytest.approx(law(replace(run, v=run.v[:, order], a=run.a[:, order])), abs=1e-6)


FRICTIONS: dict[str, tuple[dict[str, float], Callable[[Run], Floats]]] = {
    "": ({}, lambda r: 0.0 * r.v),
    "stribeck": ({"a": 0.6, "v_s": 0.4}, lambda r: 0.6 * np.exp(-((r.v / 0.4) ** 2))),
    "load_dependent_friction": ({"a": 0.1}, lambda r: 0.1 * np.abs(r.load)),
    "position_dependent_friction": (
        {"a": 0.4, "k": 3.0, "phase": 0.4, "p": 2.0},
        lambda r: 0.2 * (1 + np.sin(3.0 * r.q + 0.4)) ** 2,
    ),
    "thermal_drift": (
        {"b": 0.8, "viscous": 0.5, "T": 0.3},
        lambda r: 0.8 * np.exp(-r.t / 0.3) * (1 + 0.5 * np.abs(r.v)),
    ),
}
"""Level of dry friction in addition to Coulomb friction, on joint 2."""


@pytest.mark.parametrize("name", FRICTIONS)
def test_friction_opposes_motion_with_its_level(name: str) -> None:
    parameters, law = FRICTIONS[name]
    run = swing(machine_with(name, COULOMB, **parameters)).of_2
    assert np.ptp(law(run)) > 0.2 or not name
    assert run.added == pytest.approx((COULOMB + law(run)) * np.sign(run.v), abs=1e-4)


def test_presliding_friction_follows_dahls_model() -> None:
    run = swing(machine_with("presliding_hysteresis", COULOMB, z_s=0.02))
    bend = 0.0
    for v, added in zip(run.v[:, 1], run.added[:, 1], strict=True):
        bend += 2e-4 * (v - abs(v) * bend / 0.02)
        assert added == pytest.approx(COULOMB * bend / 0.02, abs=0.01)
    assert np.ptp(run.added[:, 1]) > 1.9 * COULOMB


def pulled(effect: EffectSpec, torque: float, steps: tuple[int, ...], viscous: float) -> list[float]:
    """Displacements of joint 2 alone, weightless, after so many steps under a constant torque [rad]."""
    pull = EffectSpec(name="torque_offset", joints=(2,), parameters={"a": torque})
    config = SimConfig(friction=Friction(viscous=(viscous,) * 3, coulomb=(COULOMB,) * 3), effects=(effect, pull))
    machine = SimulatedMachine(RIG, config, np.random.default_rng(0))
    machine.plant.model.opt.gravity = (0.0, 0.0, 0.0)
    machine.brake = [True, False, True]
    start, reached = machine.position(), []
    for count in steps:
        machine.advance([start] * count)
        reached.append(start[1] - machine.position()[1])
    return reached


@pytest.mark.parametrize("torque", [0.5, 0.9])
def test_presliding_friction_holds_up_to_its_level(torque: float) -> None:
    bristles = EffectSpec(name="presliding_hysteresis", joints=(2,), parameters={"z_s": 0.01})
    deflection, later = pulled(bristles, torque, (20000, 2000), viscous=8.0)
    assert (later - deflection > 1e-3) == (torque > COULOMB)
    assert torque > COULOMB or (1e-3 < deflection < 0.05 and abs(later - deflection) < 1e-6)


@pytest.mark.parametrize(("torque", "moves"), [(1.2, False), (1.4, True)])
def test_stribeck_friction_sticks(torque: float, moves: bool) -> None:
    """0.7 N m of Coulomb and 0.6 N m of Stribeck friction hold 1.3 N m together."""
    stribeck = EffectSpec(name="stribeck", joints=(2,), parameters={"a": 0.6, "v_s": 0.4})
    (displacement,) = pulled(stribeck, torque, (500,), viscous=0.35)
    assert (displacement > 1e-4) == moves
