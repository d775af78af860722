"""Each hidden effect by its physical signature on the machine."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.simulated.config import EffectSpec, Friction, Links, SimConfig
from drivers.simulated.machine import Machine
from recordings.rig import simulated_rig
from tests.drivers.simulated.exact_delta import exact_torque

RIG = simulated_rig()
LINKS = Links()
STILL = np.zeros((1, 3))
COULOMB = 0.7
Floats = NDArray[np.float64]


def _machine(name: str = "", coulomb: float = 0.0, **parameters: float) -> Machine:
    """A powered machine with the effect on joint 2, or on the whole robot."""
    effects = ()
    if name:
        joints = (1, 2, 3) if name in ("base_tilt", "payload_change") else (2,)
        effects = (EffectSpec(name=name, joints=joints, parameters=parameters),)
    friction = Friction(viscous=(0.0,) * 3, coulomb=(coulomb,) * 3)
    machine = Machine(RIG, SimConfig(friction=friction, effects=effects), np.random.default_rng(0))
    machine.enabled, machine.brake = [True] * 3, [False] * 3
    return machine


def _held_torque(machine: Machine, theta: Floats, seconds: float = 0.5) -> Floats:
    machine.advance([theta.tolist()] * round(seconds / machine.dt))
    return np.array(machine.torque())


def _sweep(machine: Machine) -> tuple[Floats, Floats, Floats]:
    """Speed, torque on the rigid robot before, and dry friction of joint 2 during a heave of all joints."""
    start = np.array(machine.position())
    _held_torque(machine, start, 0.2)
    time = np.arange(4000) * machine.dt
    heave = 0.3 * np.sin(2 * np.pi * time) * np.minimum(time / 0.2, 1.0)
    rows = []
    for offset in heave.tolist():
        before = machine.velocity()[1], machine.plant.rigid_torque()[1]
        machine.advance([(start + offset).tolist()])
        rows.append((*before, machine.torque()[1] - machine.plant.rigid_torque()[1]))
    speed, rigid, dry = np.array(rows).T
    sliding = np.abs(speed) > 0.05
    return speed[sliding], rigid[sliding], dry[sliding]


@pytest.mark.parametrize(
    ("name", "parameters", "law"),
    [
        ("torque_offset", {"a": 0.8}, lambda q: 0.8),
        ("joint_spring", {"k": 3.0, "q_0": 0.3}, lambda q: 3.0 * (q - 0.3)),
        ("cogging", {"a": 0.5, "N": 21.0, "phase": 0.4}, lambda q: 0.5 * math.sin(21.0 * q + 0.4)),
    ],
)
def test_static_torque_of_joint_2(name: str, parameters: dict[str, float], law: Callable[[float], float]) -> None:
    bare, hidden = _machine(), _machine(name, **parameters)
    for turn in np.linspace(-0.15, 0.15, 5):
        theta = np.array(bare.position()) * 0 + np.array([0.2, 0.2 + turn, 0.2])
        difference = _held_torque(hidden, theta) - _held_torque(bare, theta)
        assert difference == pytest.approx([0.0, law(theta[1]), 0.0], abs=2e-3)


def test_base_tilt_turns_gravity() -> None:
    machine = _machine("base_tilt", angle=0.05, direction=0.9)
    torque = _held_torque(machine, np.array(machine.position()))
    gravity = 9.81 * np.array([math.sin(0.05) * math.cos(0.9), math.sin(0.05) * math.sin(0.9), -math.cos(0.05)])
    theta = np.array([machine.position()])
    tilted, level = (exact_torque(RIG.geometry, LINKS, theta, STILL, STILL, g)[0] for g in (gravity, (0, 0, -9.81)))
    assert np.abs(tilted - level).max() > 0.1
    assert torque == pytest.approx(tilted, abs=1e-3)


def test_payload_is_heavy_and_inert_from_its_time_on() -> None:
    machine = _machine("payload_change", dm=0.8, t_c=0.3)
    loaded = Links(payload=0.8)
    for links, seconds in ((LINKS, 0.29), (loaded, 0.5)):
        torque = _held_torque(machine, np.array(machine.position()), seconds)
        theta = np.array([machine.position()])
        assert torque == pytest.approx(exact_torque(RIG.geometry, links, theta, STILL, STILL)[0], rel=2e-3)
    # Let go: without torque the motion itself tells the inertia.
    machine.enabled = [False] * 3
    machine.advance([machine.position()] * 500)
    before = np.array([machine.position()]), np.array([machine.velocity()])
    machine.advance([machine.position()])
    falling = np.array([machine.acceleration()])
    assert exact_torque(RIG.geometry, loaded, *before, falling)[0] == pytest.approx([0.0] * 3, abs=5e-3)
    assert np.abs(exact_torque(RIG.geometry, LINKS, *before, falling)[0]).max() > 0.02


def test_stribeck_friction_falls_with_speed() -> None:
    speed, _, dry = _sweep(_machine("stribeck", COULOMB, a=0.6, v_s=0.4))
    level = COULOMB + 0.6 * np.exp(-((speed / 0.4) ** 2))
    assert np.ptp(np.abs(dry)) > 0.5
    assert dry == pytest.approx(level * np.sign(speed), abs=1e-3)


def test_load_dependent_friction_follows_the_load() -> None:
    speed, rigid, dry = _sweep(_machine("load_dependent_friction", COULOMB, a=0.1))
    assert np.ptp(np.abs(dry)) > 0.3
    assert dry == pytest.approx((COULOMB + 0.1 * np.abs(rigid)) * np.sign(speed), abs=1e-2)


def test_bare_friction_is_coulombs() -> None:
    speed, _, dry = _sweep(_machine("", COULOMB))
    assert dry == pytest.approx(COULOMB * np.sign(speed), abs=1e-6)


@pytest.mark.parametrize(("push", "moves"), [(1.2, False), (1.4, True)])
def test_stribeck_friction_sticks(push: float, moves: bool) -> None:
    """0.7 N m of Coulomb and 0.6 N m of Stribeck friction hold 1.3 N m together."""
    stribeck = EffectSpec(name="stribeck", joints=(2,), parameters={"a": 0.6, "v_s": 0.4})
    pull = EffectSpec(name="torque_offset", joints=(2,), parameters={"a": push})
    friction = Friction(coulomb=(COULOMB,) * 3)
    machine = Machine(RIG, SimConfig(friction=friction, effects=(stribeck, pull)), np.random.default_rng(0))
    machine.plant.model.opt.gravity = (0.0, 0.0, 0.0)
    machine.brake = [True, False, True]
    start = machine.position()
    machine.advance([start] * 500)
    assert (start[1] - machine.position()[1] > 1e-4) == moves


@pytest.mark.parametrize("delay", [0.001, 0.00173])
def test_torque_follows_the_voltage_after_the_delay(delay: float) -> None:
    machine = _machine("actuation_delay", delay=delay)
    start = np.array(machine.position())
    said, given = [], []
    for step in range(1500):
        machine.advance([(start + 0.1 * math.sin(20 * step * machine.dt)).tolist()])
        said.append(machine.commanded_torque())
        given.append(machine.torque())
    time = np.arange(1500) * machine.dt
    late, prompt = np.interp(time - delay, time, np.array(said)[:, 1]), np.array(said)[:, 0]
    assert np.array(given)[100:, 1] == pytest.approx(late[100:], abs=1e-9)
    assert np.array_equal(np.array(given)[:, 0], prompt)


def test_voltage_leads_with_a_delay() -> None:
    machine = _machine("actuation_delay", delay=0.004)
    machine.advance([(np.array(machine.position()) + 0.05).tolist()] * 20)
    volts = 0.0005 * np.array(machine.voltage_counts())
    assert machine.torque()[1] == 0.0
    assert volts[1] * abs(volts[1]) == pytest.approx(machine.commanded_torque()[1], rel=0.05)
    assert machine.commanded_torque()[1] > 5.0
