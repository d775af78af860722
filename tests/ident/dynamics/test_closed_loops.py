"""Closed loops: a delta robot as a URDF equals our own, planar linkages, and what is refused."""

from typing import Any

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.mechanisms.urdf import Urdf
from ident.dynamics.motion import Motion
from ident.dynamics.platform import GRAVITY, platform
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from tests.ident.dynamics.loops import ARM, GEOMETRY, INERTIA, LEVER, PLATFORM, ROD, delta_keys, four_bar_keys, rig
from trajectories.kinematics import Unreachable

pytest.importorskip("pinocchio")


def states(n: int) -> Motion:
    rng = np.random.default_rng(3)
    position, velocity, acceleration = (
        rng.uniform(low, high, (n, 3)) for low, high in ((-0.3, 0.9), (-5, 5), (-100, 100))
    )
    return Motion(position, velocity, acceleration, np.sign(velocity))


@pytest.fixture(scope="module")
def delta() -> Urdf:
    return created(delta_keys())


def created(keys: dict[str, Any]) -> Urdf:
    mechanism = mechanisms.create(rig(keys))
    assert isinstance(mechanism, Urdf)
    return mechanism


def own_columns(at: Motion) -> Floats:
    """(n, 3, 12) of our own delta robot with uniform rods."""
    regressor = mechanisms.create(Rig(name="own")).regressor(at)
    return np.concatenate([regressor, platform(GEOMETRY, at).torque_of_rods[:, :, None]], axis=2)


def test_delta_of_a_urdf_is_our_own_in_torque_span_and_base_parameters(delta: Urdf) -> None:
    at = states(1000)
    columns, own = delta.regressor(at), own_columns(at)
    truth = own @ np.array([PLATFORM, ARM * GRAVITY * LEVER, *INERTIA, *6 * [0.0], ROD])
    nominal = delta.nominal_torque(at)
    np.testing.assert_allclose(nominal, truth, rtol=0, atol=1e-8 * np.abs(truth).max())

    W, wanted = columns.reshape(3000, -1), own.reshape(3000, -1)
    rest = wanted - W @ np.linalg.lstsq(W, wanted, rcond=None)[0]
    assert (np.linalg.norm(rest, axis=0) < 1e-8 * np.linalg.norm(wanted, axis=0)).all()

    fitted = np.linalg.lstsq(W, truth.ravel(), rcond=None)[0]
    expected = np.zeros(W.shape[1])
    count = len(delta.base.columns)
    expected[:count] = delta.base.combination @ [*delta.links.nominal_parameters, 0.0, 0.0, 0.0]
    np.testing.assert_allclose(fitted, expected, rtol=1e-6, atol=1e-6 * np.abs(expected).max())


def test_inertia_gravity_and_tilt_are_those_of_our_own(delta: Urdf) -> None:
    at = states(20)
    values = np.zeros(len(delta.parameters))
    values[: len(delta.base.columns)] = delta.base.combination @ [*delta.links.nominal_parameters, 0.0, 0.0, 0.0]
    inertia = delta.inertia(at, values)
    np.testing.assert_allclose(inertia, inertia.swapaxes(1, 2), atol=1e-9)
    assert (np.linalg.eigvalsh(inertia) > 0).all()
    tilted = created({**delta_keys(), "gravity": (0.3, -0.2, -9.81)}).gravity(at, values)
    turned = delta.gravity(at, values) + delta.sideways(at, values) @ [0.3, -0.2]
    np.testing.assert_allclose(turned, tilted, atol=1e-9)


def test_payload_is_carried_by_the_tool(delta: Urdf) -> None:
    at, place = states(20), (0.1, 0.0, -0.1)
    held = platform(GEOMETRY, at).torque_per_mass
    np.testing.assert_allclose(delta.torque_per_mass(at, place), held, atol=1e-9)
    loaded = created({**delta_keys(), "payload": {"mass": 2.0, "com": place}}).nominal_torque(at)
    np.testing.assert_allclose(loaded - delta.nominal_torque(at), 2.0 * held, atol=1e-9)  # type: ignore[operator]


def test_unknown_instants_stay_unknown_and_change_no_others(delta: Urdf) -> None:
    at = states(5)
    whole = delta.regressor(at)
    at.position[2, 1] = at.acceleration[4, 0] = np.nan
    missing, whole = (columns[:, :, : len(delta.base.columns)] for columns in (delta.regressor(at), whole))
    assert np.isnan(missing[[2, 4]]).all()
    np.testing.assert_allclose(missing[[0, 1, 3]], whole[[0, 1, 3]], atol=1e-8)


def test_joints_that_follow_are_numbered_after_the_driven_ones() -> None:
    names = {parameter.name: parameter.meaning for parameter in created(four_bar_keys()).parameters}
    assert "Iyy_1+" in names
    assert "3" in names["Iyy_1+"]


@pytest.mark.parametrize(("start", "side"), [({}, 1), ({"elbow": -2.0, "pivot": 2.5}, -1)])
def test_start_tells_on_which_side_a_linkage_is(start: dict[str, float], side: int) -> None:
    """A parallelogram carries its coupler without turning it; the crossed one turns it."""
    linkage = created(four_bar_keys(start=start))
    angle = np.linspace(0.1, 0.7, 30)[:, None]
    at = Motion(angle, 0 * angle, 0 * angle, 0 * angle)
    (q, _, _), _ = linkage.links.followers.along(angle, 0 * angle, 0 * angle)  # type: ignore[union-attr]
    names = [name.removeprefix("joint:") for name in linkage.links.model.names]
    place = dict(zip(names[1:], q.T, strict=True))
    assert np.allclose(place["pivot"], angle[:, 0]) == (side > 0)
    tip = 0.3 * np.stack([-np.sin(angle[:, 0]), np.cos(angle[:, 0])]) + 0.5 * np.stack(
        [np.cos(angle[:, 0] + place["elbow"]), np.sin(angle[:, 0] + place["elbow"])]
    )
    rocker = np.array([[0.5], [0.0]]) + 0.3 * np.stack([-np.sin(place["pivot"]), np.cos(place["pivot"])])
    np.testing.assert_allclose(tip, rocker, atol=1e-12)
    height = 0.3 * np.cos(angle[:, 0]) + 0.25 * np.sin(angle[:, 0] + place["elbow"])
    held = linkage.nominal_torque(at)[1:-1, 0]  # type: ignore[index]
    np.testing.assert_allclose(held, np.gradient(2.0 * 9.81 * height, angle[:, 0])[1:-1], atol=2e-2)


@pytest.mark.parametrize(
    ("keys", "reason"),
    [
        (
            four_bar_keys(rocker=2.0),
            "loops: points that meet near start expected, 1.* m between two found at .*start = ",
        ),
        (four_bar_keys(joints=("pivot",), fixed={"drive": 0.0, "elbow": 0.0}), "neither driven nor fixed expected"),
        (
            {**four_bar_keys(), "loops": ({"a": "coupler", "b": "drive", "point_b": (0.0, 0.0, 0.3)},)},
            "elbow can move while they stand; name it in joints or fixed",
        ),
    ],
)
def test_loops_that_cannot_be_are_explained(keys: dict[str, Any], reason: str) -> None:
    with pytest.raises((BadInput, ValueError), match=reason):
        created(keys)


def test_motion_in_which_the_loops_do_not_close_is_named() -> None:
    linkage = created(four_bar_keys(rocker=0.15))
    angle = np.array([[0.0], [0.1], [1.5]])
    with pytest.raises(Unreachable, match=r"^row 2: loops that close expected, driven joints at 1\.5 found"):
        linkage.regressor(Motion(angle, 0 * angle, 0 * angle, 0 * angle))
