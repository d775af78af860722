"""Hidden effects of amplifiers and encoders, each compared with its law on the machine."""

import math
from collections.abc import Callable

import numpy as np
import pytest

from tests.drivers.simulated.swinging import Floats, held_torque, machine_with, reporting, swing


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
