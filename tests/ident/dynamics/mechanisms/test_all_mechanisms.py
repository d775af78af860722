"""Requirements on every mechanism and form: its inertia and gravity are in its columns, and gaps stay gaps."""

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.mechanisms import RigidMechanism
from ident.dynamics.motion import Motion
from recordings.rig import simulated_rig
from tests.ident.dynamics.mechanisms import test_axes

KINDS = ["axes", "delta", "lagrange14", "urdf"]


def create(kind: str) -> RigidMechanism:
    if kind == "urdf":
        from tests.ident.dynamics.mechanisms import test_urdf  # skips without pinocchio

        return mechanisms.create(test_urdf.rig())
    if kind == "axes":
        return mechanisms.create(test_axes.RIG)
    return mechanisms.create(simulated_rig(), None if kind == "delta" else kind)


def angles() -> np.ndarray:
    return np.random.default_rng(1).uniform(-0.5, 0.5, (40, 3))


@pytest.mark.parametrize("kind", KINDS)
def test_inertia_and_gravity_are_what_the_columns_give_at_rest(kind: str) -> None:
    mechanism, zero = create(kind), np.zeros((40, 3))
    values = np.linspace(1.0, 2.0, len(mechanism.parameters))
    at_rest = Motion(angles(), zero, zero, zero)
    gravity = mechanism.regressor(at_rest) @ values
    np.testing.assert_allclose(mechanism.gravity(at_rest, values), gravity, rtol=1e-9, atol=1e-12)
    for joint, unit in enumerate(np.eye(3)):
        column = mechanism.regressor(Motion(at_rest.position, zero, zero + unit, zero)) @ values - gravity
        np.testing.assert_allclose(mechanism.inertia(at_rest, values)[:, :, joint], column, atol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_results_are_nan_at_an_unknown_instant_only(kind: str) -> None:
    mechanism, q = create(kind), angles()
    q[7, 1] = np.nan
    motion = Motion(q, q + 0.1, q - 0.1, np.sign(q))
    for result in (mechanism.regressor(motion), mechanism.nominal_torque(motion)):
        assert result is None or np.flatnonzero(np.isnan(result).reshape(40, -1).any(axis=1)).tolist() == [7]
    if kind == "axes":  # the other axes know nothing of it
        assert np.isfinite(mechanism.regressor(motion)[7, [0, 2]]).all()
