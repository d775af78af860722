"""Hidden effects on the machine, each compared with its law: torques and friction, drives, masses and lengths.

The torques of motors have the same law in the second plant, two programs by two hands.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, Friction, Links, SimConfig
from drivers.simulated.machine import SimulatedMachine
from tests.drivers.simulated.exact_delta import exact_torque
from tests.drivers.simulated.swinging import (
    RIG,
    Floats,
    Run,
    held_torque,
    machine_with,
    powered,
    reporting,
    spec_of,
    swing,
)
from tests.foreign import laws
from tests.foreign.balls import ball_torques
from trajectories import kinematics

COULOMB = 0.7
NO_FRICTION = np.zeros(3)

IN_BOTH_PLANTS: dict[str, dict[str, float]] = {
    "torque_offset": {"a": 0.8},
    "joint_spring": {"k": 3.0, "q_0": 0.3},
    "cogging": {"a": 0.5, "N": 21.0, "phase": 0.4},
    "asymmetric_viscous": {"a": 0.4},
    "quadratic_friction": {"a": 0.3},
    "power_law_friction": {"c": 0.6, "alpha": 0.5},
    "position_torque": {"a": 20.0, "q_0": -0.3, "p": 2.5},
    "stribeck": {"a": 0.6, "v_s": 0.4},
    "load_dependent_friction": {"a": 0.1},
    "directional_load_friction": {"a_d": 0.2, "back": 0.3},
    "stribeck_load_friction": {"a": 0.2, "v_s": 0.4},
    "position_dependent_friction": {"a": 0.4, "k": 3.0, "phase": 0.4, "p": 2.0},
    "thermal_drift": {"b": 0.8, "viscous": 0.5, "T": 0.3},
    "presliding_hysteresis": {"z_s": 0.02},
}


@pytest.mark.parametrize("name", IN_BOTH_PLANTS)
def test_torque_is_that_of_the_second_plant_while_the_joint_slides(name: str) -> None:
    parameters = IN_BOTH_PLANTS[name]
    run = swing(machine_with(name, COULOMB, **parameters))
    state = laws.State(run.t[:, None], run.q, run.v, run.a, run.load, np.full(3, COULOMB), NO_FRICTION)
    law = laws.MOTOR[name](state, parameters)
    expected = (law + COULOMB * np.sign(run.v))[:, 1]
    slides = np.abs(run.v[:, 1]) > 0.05
    assert np.abs(law[slides, 1]).max() > 0.05
    # The second plant integrates bristles by another rule.
    assert run.added[slides, 1] == pytest.approx(
        expected[slides], abs=0.01 if name.startswith("presliding") else 1e-4
    )


@pytest.mark.parametrize(
    ("name", "parameters", "law"),
    [
        ("arm_com_offset", {"a": -1.2}, lambda q: -1.2 * math.sin(q)),
        ("arm_mass_mismatch", {"a": 1.1}, lambda q: 1.1 * math.cos(q)),
    ],
)
def test_static_torque_of_joint_2(name: str, parameters: dict[str, float], law: Callable[[float], float]) -> None:
    bare, hidden = machine_with(), machine_with(name, **parameters)
    for turn in (-0.15, 0.1):
        theta = np.array([0.2, 0.2 + turn, 0.2])
        difference = held_torque(hidden, theta) - held_torque(bare, theta)
        assert difference == pytest.approx([0.0, law(theta[1]), 0.0], abs=2e-3)


OUT_OF_LIBRARY: dict[str, tuple[dict[str, float], Callable[[Run], Floats]]] = {
    "pulsation": ({"a": 0.5, "f": 7.3, "phase": 0.6}, lambda r: 0.5 * np.sin(2 * np.pi * 7.3 * r.t + 0.6)),
    "hose_drag": ({"c": 0.3}, lambda r: 0.3 * (r.v[:, 1] - r.v[:, 0])),
    "rotor_coupling": ({"J": 0.02}, lambda r: 0.02 * r.a[:, 0]),
}
"""Laws of joint 2; effects between joints couple joints 1 and 2."""


@pytest.mark.parametrize("name", OUT_OF_LIBRARY)
def test_added_torque(name: str) -> None:
    parameters, law = OUT_OF_LIBRARY[name]
    run = swing(machine_with(name, **parameters))
    assert np.std(law(run)) > 0.05
    assert run.added[:, 1] == pytest.approx(law(run), abs=1e-6)
    assert np.abs(run.added[:, 2]).max() < 1e-6
    if name != "pulsation":  # what couples two joints acts on both
        order = [1, 0, 2]
        mirrored = replace(run, v=run.v[:, order], a=run.a[:, order])
        assert run.added[:, 0] == pytest.approx(law(mirrored), abs=1e-6)


BRISTLES = EffectSpec(name="presliding_hysteresis", joints=(2,), parameters={"z_s": 0.01})
STRIBECK = EffectSpec(name="stribeck", joints=(2,), parameters={"a": 0.6, "v_s": 0.4})


@pytest.mark.parametrize(
    ("effect", "torque", "moves"),
    [
        (BRISTLES, 0.5, False),
        (BRISTLES, 0.9, True),
        # 0.7 N m of Coulomb and 0.6 N m of Stribeck friction hold 1.3 N m together.
        (STRIBECK, 1.2, False),
        (STRIBECK, 1.4, True),
    ],
)
def test_friction_holds_up_to_its_level(effect: EffectSpec, torque: float, moves: bool) -> None:
    """Joint 2 alone, weightless, under a constant torque: how far it has come, and comes in 0.4 s more."""
    pull = EffectSpec(name="torque_offset", joints=(2,), parameters={"a": torque})
    config = SimConfig(friction=Friction(viscous=(8.0,) * 3, coulomb=(COULOMB,) * 3), effects=(effect, pull))
    machine = SimulatedMachine(RIG, config, np.random.default_rng(0))
    machine.plant.model.opt.gravity = (0.0, 0.0, 0.0)
    machine.brake = [True, False, True]
    start, reached = machine.position(), [0.0]
    for steps in (20_000, 2000):
        machine.advance([start] * steps)
        reached.append(start[1] - machine.position()[1])
    bent, further = np.diff(reached)
    assert (further > 1e-3) == moves
    assert moves or (abs(further) < 1e-6 and (bent > 1e-3) == (effect is BRISTLES))


def _volts(torque: Floats, exponent: float = 2.0) -> Floats:
    volts: Floats = np.sign(torque) * np.abs(torque) ** (1 / exponent)
    return volts


@pytest.mark.parametrize(
    ("name", "parameters", "law"),
    [
        ("back_emf", {"k_e": 0.2}, lambda motor_torque, v: _volts(motor_torque) + 0.2 * v),
        ("torque_gain_mismatch", {"mismatch": 0.2}, lambda motor_torque, v: _volts(motor_torque / 1.2)),
        ("torque_map_exponent", {"excess": -0.3}, lambda motor_torque, v: _volts(motor_torque, 1.7)),
    ],
)
def test_reported_voltage(name: str, parameters: dict[str, float], law: Callable[[Floats, Floats], Floats]) -> None:
    run = swing(machine_with(name, **parameters))
    after, motor_torque, reported = run.v[1:], run.motor_torque[:-1], run.reported[:-1]
    assert _volts(reported)[:, 1] == pytest.approx(law(motor_torque[:, 1], after[:, 1]), abs=1e-9)
    assert reported[:, 0] == pytest.approx(motor_torque[:, 0], abs=1e-9)
    assert np.abs(reported - motor_torque)[:, 1].max() > 0.5


@pytest.mark.parametrize(
    ("name", "parameters", "law"),
    [
        ("amplifier_deadband", {"width": 0.3}, lambda u: np.sign(u) * np.maximum(np.abs(u) - 0.3, 0.0)),
        ("amplifier_saturation", {"inverse_level": 0.25, "n": 4.0}, lambda u: u / (1 + (u / 4) ** 4) ** 0.25),
    ],
)
def test_amplifier_loses_voltage_between_command_and_motor(
    name: str, parameters: dict[str, float], law: Callable[[Floats], Floats]
) -> None:
    commanded, measured = (
        swing(machine_with(name, rig=reporting(kind), **parameters)) for kind in ("command", "motor")
    )
    assert np.array_equal(commanded.motor_torque, measured.motor_torque)
    assert _volts(commanded.motor_torque)[:, 1] == pytest.approx(law(_volts(commanded.reported)[:, 1]), abs=1e-9)
    assert measured.reported == pytest.approx(measured.motor_torque, abs=1e-9)
    assert np.abs(commanded.reported - commanded.motor_torque)[:, 1].max() > 0.5


def test_zero_offset_shifts_the_true_position() -> None:
    machine, theta = machine_with("encoder_zero_offset", c=0.02), np.array([0.2, 0.1, 0.3])
    held_torque(machine, theta)
    assert machine.position() == pytest.approx(theta, abs=1e-5)
    assert machine.plant.motor_angles() == pytest.approx(theta - [0.0, 0.02, 0.0], abs=1e-5)


def test_drive_follows_the_eccentric_encoder() -> None:
    machine = machine_with("encoder_eccentricity", a=0.002, N=21.0, phase=0.4)
    start = np.array(machine.position())
    rows = []
    for step in range(1500):
        setpoint = start + 0.1 * math.sin(10 * step * machine.dt)
        machine.advance([setpoint.tolist()])
        rows.append((setpoint, machine.position(), machine.velocity(), machine.plant.motor_angles()))
    setpoint, read, speed, true = np.moveaxis(np.array(rows)[500:], 1, 0)
    assert read[:, 1] == pytest.approx(true[:, 1] + 0.002 * np.sin(21.0 * true[:, 1] + 0.4), abs=1e-12)
    assert np.array_equal(read[:, [0, 2]], true[:, [0, 2]])
    assert np.abs(read - setpoint)[:, 1].max() < 1e-3 < np.abs(true - setpoint)[:, 1].max()
    assert np.diff(read, axis=0)[:, 1] / machine.dt == pytest.approx(speed[1:, 1], abs=5e-3)


@pytest.mark.parametrize("delay", [0.001, 0.00173])
def test_torque_follows_the_voltage_after_the_delay(delay: float) -> None:
    machine = machine_with("actuation_delay", delay=delay)
    start = np.array(machine.position())
    reported, motor_torque = [], []
    for step in range(1500):
        machine.advance([(start + 0.1 * math.sin(20 * step * machine.dt)).tolist()])
        reported.append(machine.reported_torque())
        motor_torque.append(machine.torque())
    time = np.arange(1500) * machine.dt
    late, prompt = np.interp(time - delay, time, np.array(reported)[:, 1]), np.array(reported)[:, 0]
    assert np.array(motor_torque)[100:, 1] == pytest.approx(late[100:], abs=1e-9)
    assert np.array(motor_torque)[:, 0] == pytest.approx(prompt, abs=1e-12)


STILL = np.zeros((1, 3))
LINKS = Links()


def test_base_tilt_turns_gravity() -> None:
    machine = machine_with("base_tilt", angle=0.05, direction=0.9)
    torque = held_torque(machine, np.array(machine.position()))
    gravity = 9.81 * np.array([math.sin(0.05) * math.cos(0.9), math.sin(0.05) * math.sin(0.9), -math.cos(0.05)])
    theta = np.array([machine.position()])
    tilted, level = (exact_torque(RIG.geometry, LINKS, theta, STILL, STILL, g)[0] for g in (gravity, (0, 0, -9.81)))
    assert np.abs(tilted - level).max() > 0.1
    assert torque == pytest.approx(tilted, abs=1e-3)


def test_payload_adds_weight_and_inertia_from_its_time_on() -> None:
    machine = machine_with("payload_change", dm=0.8, t_c=0.3)
    loaded = Links(payload=0.8)
    for links, seconds in ((LINKS, 0.29), (loaded, 0.5)):
        torque = held_torque(machine, np.array(machine.position()), seconds)
        theta = np.array([machine.position()])
        assert torque == pytest.approx(exact_torque(RIG.geometry, links, theta, STILL, STILL)[0], rel=2e-3)
    assert falling(machine, loaded) == pytest.approx([0.0] * 3, abs=5e-3)


def falling(machine: SimulatedMachine, links: Links) -> Floats:
    """Torque (3,) that these links would need for the motion in free fall: none if they are the machine's."""
    machine.enabled = [False] * 3
    machine.advance([machine.position()] * 500)
    before = np.array([machine.position()]), np.array([machine.velocity()])
    machine.advance([machine.position()])
    return exact_torque(RIG.geometry, links, *before, np.array([machine.plant.motor_accelerations()]))[0]


def test_air_drag_opposes_the_platforms_motion() -> None:
    run = swing(machine_with("air_drag", c=3.0))
    # The load of a step belongs to the state at its beginning.
    theta, rate, acceleration, load = run.q[:-1], run.v[:-1], run.a[1:], run.load[1:]
    still_air = exact_torque(RIG.geometry, LINKS, theta, rate, acceleration)
    _, velocity, _, J = kinematics.platform_motion(RIG.geometry, theta, rate, acceleration)
    force = 3.0 * np.linalg.norm(velocity, axis=1, keepdims=True) * velocity
    expected = np.einsum("nji,nj->ni", J, force)
    assert np.ptp(expected) > 0.5
    assert load - still_air == pytest.approx(expected, abs=0.02)


def test_balls_of_the_rods_brake_the_joints_as_in_the_second_plant() -> None:
    run = swing(machine_with("passive_joint_friction", mu=0.4, viscous=0.2))
    theta, rate, acceleration, load = run.q[:-1], run.v[:-1], run.a[1:], run.load[1:]
    dry, viscous = ball_torques(RIG.geometry, theta, rate)
    expected = 0.4 * dry + 0.08 * viscous
    added = load - exact_torque(RIG.geometry, LINKS, theta, rate, acceleration)
    assert np.abs(expected).max() > 0.5
    # In the plant, dry friction of a ball that hardly turns is less.
    assert np.mean(np.abs(added - expected) < 0.02) > 0.95


def test_friction_falls_as_a_joint_warms_itself() -> None:
    friction = Friction(viscous=(0.4,) * 3, coulomb=(COULOMB,) * 3)
    heated = SimConfig(friction=friction, effects=(spec_of("self_heating", fall=0.3, power=2.0, T=0.3),))
    run = swing(powered(heated))
    v = run.v[:, 1]
    power, dt = 0.4 * v**2 + COULOMB * np.abs(v), run.t[1] - run.t[0]
    warmth = np.zeros_like(v)
    for k in range(1, len(v)):
        warmth[k] = warmth[k - 1] + (power[k - 1] / 2.0 - warmth[k - 1]) * dt / 0.3
    slides = np.abs(v) > 0.1
    expected = (0.4 * v + COULOMB * np.sign(v)) * (1 - 0.3 * warmth)
    assert warmth.max() > 0.5
    assert run.added[slides, 1] == pytest.approx(expected[slides], abs=0.02)


@pytest.mark.parametrize("name", ["L1", "L2", "R", "r"])
def test_platform_position_follows_from_the_true_lengths(name: str) -> None:
    shares = {"L1": 0.0, "L2": 0.0, "R": 0.0, "r": 0.0, name: 1.0}
    machine = machine_with("geometry_error", error=0.02, **shares)
    theta = np.array([0.2, 0.1, 0.3])
    held_torque(machine, theta)
    true = RIG.geometry.model_copy(update={name: getattr(RIG.geometry, name) + 0.02})
    angles = np.array([machine.plant.motor_angles()])
    assert machine.plant.platform() == pytest.approx(kinematics.forward(true, angles)[0], abs=1e-5)
    assert np.abs(machine.plant.platform() - kinematics.forward(RIG.geometry, angles)[0]).max() > 0.005
