"""A plant that all tests share: it is costly to make."""

import numpy as np
import pytest

from tests.foreign import courses, robots
from tests.foreign.plant import Plant
from tests.foreign.sizing import EffectSizer


def _plant(kind: robots.Kind, shape: courses.Shape) -> Plant:
    rng = np.random.default_rng(3)
    robot = robots.draw(kind, rng, rate=500.0, bits=18, reports_command=True)
    return Plant(robot, courses.draw(robot.rig.geometry, shape, rng, rate=500.0, seconds=8.0))


@pytest.fixture(scope="package")
def plant() -> Plant:
    """A heavy robot, whose torques do not change their sign."""
    return _plant("heavy", "stations")


@pytest.fixture(scope="package")
def light() -> Plant:
    """A light one, whose torques do."""
    return _plant("light", "fourier")


@pytest.fixture(scope="package")
def ruler(plant: Plant) -> EffectSizer:
    """Of the heavy one."""
    return EffectSizer(plant)
