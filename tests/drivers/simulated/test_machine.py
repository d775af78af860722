import math

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, Servo, SimConfig, SimEvent
from drivers.simulated.machine import MAX_STEP, SimulatedMachine, plant_step
from recordings.rig import Drive, Rig, Torque, Voltage
from tests.drivers.simulated.swinging import RIG, powered

QUIET = SimConfig(voltage_noise=0.0)


def _hold(machine: SimulatedMachine, seconds: float) -> None:
    machine.advance([machine.position()] * round(seconds / machine.dt))


def _running(config: SimConfig = QUIET, rig: Rig = RIG) -> SimulatedMachine:
    """A machine that has held its position with power for 0.3 s."""
    machine = powered(config, rig)
    _hold(machine, 0.3)
    return machine


def test_brakes_hold_without_power_and_without_them_the_robot_falls() -> None:
    machine = powered(QUIET)
    machine.enabled, machine.brake = [False] * 3, [True] * 3
    start = np.array(machine.position())
    _hold(machine, 0.2)
    assert machine.time == pytest.approx(0.2)
    assert np.abs(machine.position() - start).max() < 1e-6
    assert machine.torque() == [0.0, 0.0, 0.0]
    machine.brake = [False] * 3
    _hold(machine, 0.2)
    assert np.all(machine.position() < start - 0.05)


def test_torque_limit_holds() -> None:
    machine = powered(SimConfig(servo=Servo(torque_limit=25.0)))
    far = [q + 0.2 for q in machine.position()]
    largest = 0.0
    for _ in range(200):
        machine.advance([far])
        largest = max(largest, *map(abs, machine.torque()))
    assert 24.0 < largest <= 25.0


def test_power_cycle_clears_the_loops_memory_and_reset_restores_the_initial_state() -> None:
    remembering = (EffectSpec(name="presliding_hysteresis"), EffectSpec(name="actuation_delay"))
    begun = SimEvent(at=0.15, effect=EffectSpec(name="joint_spring"))
    config = QUIET.model_copy(update={"effects": remembering, "events": (begun,)})
    machine, fresh = _running(config), powered(config)
    assert np.abs(machine.torque()).min() > 1.0
    machine.enabled, machine.brake = [False] * 3, [True] * 3
    _hold(machine, 0.1)
    assert np.abs(machine.torque()).max() < 1e-6
    machine.enabled = [True] * 3
    machine.advance([machine.position()])
    assert np.abs(machine.torque()).max() < 0.1
    for each in (machine, fresh):
        each.reset((0.1, 0.0, -0.8))
    assert machine.time == 0.0
    assert machine.brake == [True] * 3
    for each in (machine, fresh):
        each.enabled, each.brake = [True] * 3, [False] * 3
        _hold(each, 0.1)
    assert machine.position() == fresh.position()
    assert machine.torque() == fresh.torque()


@pytest.mark.parametrize("kind", ["square", "linear"])
def test_voltage_is_the_inverse_of_the_torque_map_and_the_true_gain_may_differ(kind: str) -> None:
    fine = Voltage(scale=0.001)
    drives = (Drive(node_id=1, voltage=fine), Drive(node_id=2, sign=-1, voltage=fine), Drive(node_id=3, voltage=fine))
    torque = Torque.model_validate({"map": kind, "gain": (1.0, 1.2, 0.8)})
    for gain in (torque.gain, (4.0, 4.0, 4.0)):
        config = QUIET.model_copy(update={"torque_gain": gain})
        machine = _running(config, Rig(name="map", drives=drives, torque=torque))
        volts = [d.sign * d.voltage.scale * c for d, c in zip(drives, machine.voltage_counts(), strict=True)]
        mapped = [g * (v * abs(v) if kind == "square" else v) for g, v in zip(gain, volts, strict=True)]
        assert min(mapped) > 1.0
        assert mapped == pytest.approx(machine.torque(), abs=0.01)


def test_voltage_is_clipped_to_sixteen_bits_and_its_noise_gaussian() -> None:
    coarse = tuple(Drive(node_id=i, voltage=Voltage(scale=1e-6), sign=sign) for i, sign in ((1, 1), (2, -1), (3, 1)))
    clipped = _running(rig=Rig(name="clipped", drives=coarse))
    assert clipped.voltage_counts() == (0x7FFF, -0x8000, 0x7FFF)
    machine = powered(SimConfig(voltage_noise=0.02))
    volts = 0.0005 * np.array([machine.voltage_counts() for _ in range(4000)])
    assert np.std(volts, axis=0) == pytest.approx([0.02] * 3, rel=0.05)
    assert np.abs(np.mean(volts, axis=0)).max() < 5 * 0.02 / math.sqrt(4000)


@pytest.mark.parametrize("rate", [200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0, 4000.0])
def test_cycles_are_whole_numbers_of_steps(rate: float) -> None:
    dt = plant_step(rate)
    assert dt <= MAX_STEP
    assert 1 / rate / dt == pytest.approx(round(1 / rate / dt), rel=1e-12)
