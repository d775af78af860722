"""Plants that all tests share, because they are slow to create."""

import numpy as np
import pytest

from tests.foreign import reference_motion, robots
from tests.foreign.plant import Plant
from tests.foreign.sizing import EffectSizer


def _plant(kind: robots.Kind, shape: reference_motion.Shape) -> Plant:
    rng = np.random.default_rng(3)
    robot = robots.draw(kind, rng, rate=500.0, bits=18, reports_command=True)
    return Plant(robot, reference_motion.draw(robot.rig.geometry, shape, rng, rate=500.0, seconds=8.0))


@pytest.fixture(scope="package")
def plant() -> Plant:
    """Heavy robot, whose torques do not change sign."""
    return _plant("heavy", "stations")


@pytest.fixture(scope="package")
def light() -> Plant:
    """Light robot, whose torques change sign."""
    return _plant("light", "fourier")


@pytest.fixture(scope="package")
def sizer(plant: Plant) -> EffectSizer:
    """Effect sizer of the heavy robot."""
    return EffectSizer(plant)
