"""Hidden effects of masses and lengths, each compared with its law on the machine."""

import math

import numpy as np
import pytest

from drivers.simulated.config import Links
from drivers.simulated.machine import SimulatedMachine
from tests.drivers.simulated.exact_delta import exact_torque
from tests.drivers.simulated.swinging import RIG, Floats, held_torque, machine_with, swing
from trajectories import kinematics

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


def test_payload_is_put_down_again() -> None:
    machine = machine_with("payload_change", dm=0.8, t_c=0.0, t_e=0.4)
    theta = np.array([0.2, 0.1, 0.3])
    carried, empty = held_torque(machine, theta, 0.39), held_torque(machine, theta)
    assert empty == pytest.approx(exact_torque(RIG.geometry, LINKS, theta[None], STILL, STILL)[0], rel=2e-3)
    assert np.all(carried > empty + 0.3)


def falling(machine: SimulatedMachine, links: Links) -> Floats:
    """Torque (3,) that these links would need for the motion in free fall: none if they are the machine's."""
    machine.enabled = [False] * 3
    machine.advance([machine.position()] * 500)
    before = np.array([machine.position()]), np.array([machine.velocity()])
    machine.advance([machine.position()])
    return exact_torque(RIG.geometry, links, *before, np.array([machine.plant.motor_accelerations()]))[0]


def test_arm_mass_adds_inertia() -> None:
    heavy = Links(arm_mass=LINKS.arm_mass + 2.0 / (9.81 * LINKS.arm_com))
    plain, loaded = (falling(machine_with("arm_mass_mismatch", a=2.0), links) for links in (LINKS, heavy))
    assert [plain[0], loaded[1], plain[2]] == pytest.approx([0.0] * 3, abs=5e-3)
    assert abs(plain[1]) > 0.05


def test_air_drag_opposes_the_platforms_motion() -> None:
    run = swing(machine_with("air_drag", c=3.0))
    # The load of a step belongs to the state at its beginning.
    theta, rate, acceleration, load = run.q[:-1], run.v[:-1], run.a[1:], run.load[1:]
    still_air = exact_torque(RIG.geometry, LINKS, theta, rate, acceleration)
    J = kinematics.jacobian(RIG.geometry, theta, kinematics.forward(RIG.geometry, theta))
    velocity = np.einsum("nij,nj->ni", J, rate)
    force = 3.0 * np.linalg.norm(velocity, axis=1, keepdims=True) * velocity
    expected = np.einsum("nji,nj->ni", J, force)
    assert np.ptp(expected) > 0.5
    assert load - still_air == pytest.approx(expected, abs=0.02)


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
