"""Dry friction that changes along the travel of one axis."""

from types import SimpleNamespace

import numpy as np
import pytest

from ident.diagnosis.search.candidates import Candidates, Fits
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.effects.base import Additive
from ident.dynamics.effects.library import load
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from tests.ident import building

NAME = "position_dependent_friction"


def wavy(motion: Motion) -> Floats:
    product: Floats = 0.5 * np.sin(3 * motion.position) * motion.direction
    return product


@pytest.fixture(scope="module")
def two_joints() -> SplitData:
    """Two recordings of two joints, none of which has the travel of another."""
    return building.split(
        [
            building.record(2, noise=0.02, extra=wavy, shape=i, size=0.6 + 0.2 * i, name=f"motion {i}")
            for i in range(2)
        ]
    )


def travels(data: SplitData) -> Floats:
    """(4,) low and high of the first joint, then of the second."""
    positions = [
        np.where(rows, recording.motion.position, np.nan)
        for rows, recording in zip(data.train, data.recordings, strict=True)
    ]
    return np.stack([np.nanmin(np.concatenate(positions), 0), np.nanmax(np.concatenate(positions), 0)], 1).ravel()


def test_every_joint_has_its_knots_over_its_travel_in_all_training_rows(two_joints: SplitData) -> None:
    model = building.fitted(two_joints)
    (fitted,) = Candidates(Fits(two_joints), {NAME: load(NAME)}).curves(model)
    assert fitted.terms[0].joints == (0, 1)
    shapes = fitted.solution.structure.shape_values(0, fitted.solution.x)
    np.testing.assert_allclose(shapes, travels(two_joints))
    for ends, values in zip(
        shapes.reshape(2, 2), fitted.solution.structure.local_values(0, fitted.solution.x), strict=True
    ):
        expected = building.COULOMB + 0.5 * np.sin(3 * np.linspace(*ends, 9))
        np.testing.assert_allclose(values[1:-1], expected[1:-1], atol=0.05)


def test_joint_that_is_added_or_dropped_takes_its_knots_along(two_joints: SplitData) -> None:
    both = Candidates(Fits(two_joints), {NAME: load(NAME)}).curves(building.fitted(two_joints))[0]
    second = Fits(two_joints).on_joints(both, 0, [1])
    np.testing.assert_allclose(second.solution.structure.shape_values(0, second.solution.x), travels(two_joints)[2:])
    again = Fits(two_joints).on_joints(second, 0, [0, 1])
    np.testing.assert_allclose(again.solution.x, both.solution.x, rtol=1e-6, atol=1e-9)


def test_joint_that_stood_still_has_no_travel_and_finite_columns() -> None:
    effect = load(NAME)
    assert isinstance(effect, Additive)
    assert effect.merge is not None
    unknown = np.array([np.nan])
    travel = effect.merge([{"low": unknown, "high": unknown}])
    motion = building.motion_of()
    columns = effect.columns(SimpleNamespace(motion=motion), travel)  # type: ignore[arg-type]
    np.testing.assert_allclose(columns.sum(axis=2), motion.direction)
