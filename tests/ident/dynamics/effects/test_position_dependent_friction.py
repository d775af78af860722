"""Dry friction that changes along the travel of one axis."""

from dataclasses import replace

import numpy as np
import pytest

from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

SEEDS = [pytest.param(seed, marks=[pytest.mark.slow] if seed > 1 else []) for seed in range(20)]


def rubbing(seed: int) -> building.Torque:
    wave, phase = np.random.default_rng(seed).uniform((1.0, 0.0), (3.0, 2 * np.pi))

    def torque(motion: Motion) -> Floats:
        product: Floats = np.sin(wave * motion.position + phase) * motion.direction
        return product

    return building.of_size(torque, 0.03, shape=seed)


@pytest.mark.parametrize("seed", SEEDS)
def test_is_named_where_dry_friction_depends_on_the_position(seed: int) -> None:
    train, validate = (
        building.record(noise=0.05, seed=2 * seed + i, shape=shape, extra=rubbing(seed), name=f"motion {i}")
        for i, shape in enumerate((seed, seed + 1000))
    )
    assert building.named(train, validate)[0][0] == "position_dependent_friction"


def test_its_values_are_the_dry_friction_along_the_travel() -> None:
    recording = building.record(noise=0.02, extra=rubbing(0))
    model = building.structure(recording, "position_dependent_friction")
    x = building.start(model)
    x[-2:] = recording.position.min(), recording.position.max()
    x = building.split([recording]).fit(model, x).x
    at = np.linspace(x[-2], x[-1], 9)[1:-1]
    still = np.zeros_like(at[:, None])
    motion = replace(building.motion_of(), position=at[:, None], velocity=still, direction=still + 1.0)
    expected = building.COULOMB + rubbing(0)(motion)[:, 0]
    np.testing.assert_allclose(x[4:11], expected, atol=0.05)
