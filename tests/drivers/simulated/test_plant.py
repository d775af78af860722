import numpy as np
import pytest

from drivers.simulated.config import Friction, Links, SimConfig
from recordings.errors import BadInput
from tests.drivers.simulated.exact_delta import exact_torque
from tests.drivers.simulated.swinging import RIG, along_fig5a, powered
from trajectories import kinematics

ASIDE = (0.12, -0.08, -0.8)


def test_mechanism_closes_where_the_platform_is_placed() -> None:
    plant = powered(SimConfig(park=ASIDE)).plant
    assert np.abs(plant.data.efc_pos[:9]).max() < 1e-12
    assert plant.platform() == pytest.approx(ASIDE, abs=1e-12)
    assert plant.motor_angles() == pytest.approx(kinematics.inverse(RIG.geometry, np.array([ASIDE]))[0], abs=1e-12)
    with pytest.raises(BadInput, match="cannot reach"):
        powered(SimConfig(park=(0.0, 0.0, -3.0)))


def test_torque_agrees_with_exact_inverse_dynamics_along_fig5a() -> None:
    run = along_fig5a(SimConfig())
    # Acceleration and torque of a step belong to the state at its beginning.
    position, velocity, acceleration, torque = (
        rows[1000::20] for rows in (run.q[:-1], run.v[:-1], run.a[1:], run.load[1:])
    )
    exact = exact_torque(RIG.geometry, Links(), position, velocity, acceleration)
    rms = np.sqrt(np.mean(exact**2, axis=0))
    assert np.all(rms > 1.0)
    assert np.all(np.sqrt(np.mean((torque - exact) ** 2, axis=0)) < 1e-3 * rms)


def test_viscous_friction_damps_in_proportion_to_speed() -> None:
    friction = Friction(viscous=(0.5, 0.6, 0.7), coulomb=(0.0,) * 3)
    machine = powered(SimConfig(friction=friction))
    machine.enabled = [False] * 3
    machine.advance([machine.position()] * 500)
    speed = np.array(machine.plant.motor_speeds())
    assert np.all(np.abs(speed) > 0.1)
    assert machine.plant.rigid_torque() == pytest.approx(-np.array([0.5, 0.6, 0.7]) * speed, rel=0.01)
