import math

import numpy as np
import pytest
from numpy.typing import NDArray

from drivers.simulated.config import EffectSpec, Servo, SimConfig
from drivers.simulated.machine import MAX_STEP, SimulatedMachine, plant_step
from recordings.rig import Drive, Rig, Torque, Voltage, simulated_rig
from trajectories.library import load

QUIET = SimConfig(voltage_noise=0.0)


def _machine(config: SimConfig = QUIET, rig: Rig | None = None, seed: int = 0) -> SimulatedMachine:
    return SimulatedMachine(rig or simulated_rig(), config, np.random.default_rng(seed))


def _switch_on(machine: SimulatedMachine) -> None:
    machine.enabled, machine.brake = [True] * 3, [False] * 3


def _hold(machine: SimulatedMachine, seconds: float) -> None:
    machine.advance([machine.position()] * round(seconds / machine.dt))


def _running(config: SimConfig = QUIET, rig: Rig | None = None, seconds: float = 0.3) -> SimulatedMachine:
    """A machine that has held its position with power."""
    machine = _machine(config, rig)
    _switch_on(machine)
    _hold(machine, seconds)
    return machine


def test_brakes_hold_without_power_and_without_them_the_robot_falls() -> None:
    machine = _machine()
    start = np.array(machine.position())
    _hold(machine, 0.2)
    assert machine.time == pytest.approx(0.2)
    assert np.abs(machine.position() - start).max() < 1e-6
    assert machine.torque() == [0.0, 0.0, 0.0]
    machine.brake = [False] * 3
    _hold(machine, 0.2)
    assert np.all(machine.position() < start - 0.05)


def test_holds_still_without_limit_cycle() -> None:
    machine = _machine()
    _switch_on(machine)
    start = machine.position()
    machine.advance([start] * 5000)
    torque = []
    for _ in range(100):
        machine.advance([start] * 10)
        torque.append(machine.torque())
    assert np.ptp(torque, axis=0).max() < 1e-2
    assert np.abs(machine.velocity()).max() < 1e-6
    assert np.abs(machine.following_error()).max() < 1e-3


def _fig5a_by_straight_lines(machine: SimulatedMachine, rig: Rig) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Torque at every step and following error at every SYNC, with linear interpolation between the targets."""
    trajectory = load("fig5a", rig, cycles=1)
    machine.reset(trajectory.platform[0].tolist())
    _switch_on(machine)
    steps = round(1 / rig.rate / machine.dt)
    share = np.arange(1, steps + 1)[:, None] / steps
    torque, error = [], []
    for start, end in zip(trajectory.joint_position, trajectory.joint_position[1:], strict=False):
        for row in (start + share * (end - start)).tolist():
            machine.advance([row])
            torque.append(machine.torque())
        error.append(machine.following_error())
    return np.array(torque), np.array(error)


def test_follows_fig5a_with_small_error_and_little_torque_ripple_at_sync_rate() -> None:
    rig = simulated_rig()
    torque, error = _fig5a_by_straight_lines(_machine(rig=rig), rig)
    assert np.abs(error).max() < 0.005
    steady = torque[7500:22500]
    spectrum = np.abs(np.fft.rfft(steady * np.hanning(len(steady))[:, None], axis=0)) * 4 / len(steady)
    frequency = np.fft.rfftfreq(len(steady), 2e-4)
    at_sync = (frequency > 490) & (frequency < 510)
    assert np.sqrt(np.sum(spectrum[at_sync] ** 2, axis=0)).max() < 5e-3


def test_torque_limit_holds() -> None:
    machine = _machine(SimConfig(servo=Servo(torque_limit=25.0)))
    _switch_on(machine)
    far = [q + 0.2 for q in machine.position()]
    largest = 0.0
    for _ in range(200):
        machine.advance([far])
        largest = max(largest, *map(abs, machine.torque()))
    assert 24.0 < largest <= 25.0


def test_one_axis_can_be_switched_alone() -> None:
    machine = _machine()
    machine.enabled[1], machine.brake[1] = True, False
    target = machine.position()
    target[1] += 0.02
    machine.advance([target] * 3000)
    assert machine.position() == pytest.approx(target, abs=1e-4)
    assert machine.torque()[0] == machine.torque()[2] == 0.0


def test_power_cycle_clears_the_loops_memory_and_reset_restores_the_initial_state() -> None:
    remembering = (EffectSpec(name="presliding_hysteresis"), EffectSpec(name="actuation_delay"))
    config = QUIET.model_copy(update={"effects": remembering})
    machine, fresh = _running(config), _machine(config)
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
        _switch_on(each)
        _hold(each, 0.1)
    assert machine.position() == fresh.position()
    assert machine.torque() == fresh.torque()


def test_same_seed_gives_identical_outputs() -> None:
    def run(seed: int) -> list[object]:
        machine = _machine(SimConfig(), seed=seed)
        _switch_on(machine)
        outputs: list[object] = []
        for _ in range(20):
            _hold(machine, 0.002)
            outputs.append((machine.encoder_counts(), machine.voltage_counts()))
        return outputs

    assert run(3) == run(3)
    assert run(3) != run(4)


def test_encoder_counts_with_sign_and_zero_offset() -> None:
    drives = (Drive(node_id=1), Drive(node_id=2, sign=-1, zero_offset=0.3), Drive(node_id=3, counts_per_turn=4096))
    machine = _machine(rig=Rig(name="signs", drives=drives))
    angles = [d.zero_offset + c / d.counts_per_radian for d, c in zip(drives, machine.encoder_counts(), strict=True)]
    assert angles == pytest.approx(machine.position(), abs=0.5001 / abs(drives[2].counts_per_radian))
    assert all(isinstance(count, int) for count in machine.encoder_counts())


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
    machine = _machine(SimConfig(voltage_noise=0.02))
    volts = 0.0005 * np.array([machine.voltage_counts() for _ in range(4000)])
    assert np.std(volts, axis=0) == pytest.approx([0.02] * 3, rel=0.05)
    assert np.abs(np.mean(volts, axis=0)).max() < 5 * 0.02 / math.sqrt(4000)


@pytest.mark.parametrize("rate", [200.0, 250.0, 400.0, 500.0, 1000.0, 2000.0, 4000.0])
def test_cycles_are_whole_numbers_of_steps(rate: float) -> None:
    dt = plant_step(rate)
    assert dt <= MAX_STEP
    assert 1 / rate / dt == pytest.approx(round(1 / rate / dt), rel=1e-12)
