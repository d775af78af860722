"""Effects that begin while the simulated machine runs."""

import numpy as np
import pytest

from drivers.simulated.config import EffectSpec, SimConfig, SimEvent
from drivers.simulated.effect import library
from recordings.recording import Floats
from tests.drivers.simulated.swinging import powered

AT, END = 0.2, 0.4
"""When the effect begins, and the end [s]."""


def moved(config: SimConfig) -> Floats:
    """(cycles, 2, 3) position and reported torque of a machine whose setpoint swings."""
    machine = powered(config)
    start, rows = machine.position(), []
    steps = round(0.002 / machine.dt)
    for cycle in range(round(END / 0.002)):
        times = 0.002 * cycle + machine.dt * np.arange(steps)
        machine.advance((np.array(start) + 0.1 * (1 - np.cos(9 * times))[:, None]).tolist())
        rows.append((machine.position(), machine.reported_torque()))
    return np.array(rows)


def event(name: str, at: float = AT) -> SimConfig:
    return SimConfig(events=(SimEvent(at=at, effect=EffectSpec(name=name)),))


@pytest.fixture(scope="module")
def bare() -> Floats:
    """Without any effect."""
    return moved(SimConfig())


@pytest.mark.parametrize("name", sorted(library()))
def test_effect_begins_at_its_instant_and_the_robot_goes_on(name: str, bare: Floats) -> None:
    found, before = moved(event(name)), round(AT / 0.002)
    np.testing.assert_array_equal(found[:before], bare[:before])
    assert np.isfinite(found).all()
    assert np.abs(np.diff(found[:, 0], axis=0)).max() < 0.02 + np.abs(np.diff(bare[:, 0], axis=0)).max()


def test_torque_is_that_of_a_machine_with_the_effect(bare: Floats) -> None:
    effects = (EffectSpec(name="quadratic_friction"),)
    found, from_the_beginning = moved(event("quadratic_friction", 0.1)), moved(SimConfig(effects=effects))
    torque, without, expected = (each[-50:, 1] for each in (found, bare, from_the_beginning))
    assert np.abs(torque - expected).max() < 0.1 * np.abs(without - expected).max()
