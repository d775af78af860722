from collections.abc import Callable

import numpy as np
import pytest

from ident.data.prepared_recording import prepare
from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from ident.estimation import estimators
from ident.estimation.linear_fit import fit
from ident.estimation.regression import Regression
from recordings.errors import BadInput
from recordings.recording import Recording
from recordings.rig import Axis, Rig, simulated_rig
from trajectories import kinematics

RIG = simulated_rig()
THETA_HAT = np.array([0.4, 1.1, -2.0, 3.0, -5.0, 0.7, 1.3, 0.2, -2.5, 0.9, -1.7, 0.6, 2.2, -0.8])


def motion() -> Motion:
    rng = np.random.default_rng(0)
    position, velocity, acceleration = rng.uniform(-0.5, 0.9, (3, 20, 3))
    return Motion(position, velocity, acceleration, np.sign(velocity))


def test_is_eq_37_term_by_term() -> None:
    moving = motion()
    columns = mechanisms.create(RIG, "lagrange14").regressor(moving)
    t, h = moving.position, THETA_HAT
    x, y, z = kinematics.forward(RIG.geometry, t).T
    s, c = np.sin, np.cos
    expected = [
        h[0] * moving.acceleration[:, i]
        - h[a] * x * s(t[:, i])
        - h[b] * y * s(t[:, i])
        + h[d] * z * c(t[:, i])
        - h[4] * c(t[:, i])
        + h[e] * s(t[:, i])
        for i, (a, b, d, e) in enumerate([(1, 2, 3, 5), (6, 7, 8, 9), (10, 11, 12, 13)])
    ]
    np.testing.assert_allclose(columns @ h, np.stack(expected, axis=1), rtol=1e-12)


@pytest.mark.parametrize("method", ["rls", "dls", "svd", "ls"])
def test_planted_parameters_are_recovered(make: Callable[..., Recording], method: str) -> None:
    """The torque fits the model exactly; svd is used without truncation."""
    recording = make("excitation", cycles=1)
    prepared = prepare(recording, "parallel", None, form="lagrange14")
    exact = np.where(prepared.usable, prepared.regressor @ THETA_HAT, np.nan)
    regression = Regression(prepared, prepared.regressor, exact)
    arguments = {"svd": {"threshold": 1e-6}, "dls": {"damping": 1e-6}}.get(method, {})
    settings = estimators.settings(method, arguments)
    estimate = fit(
        [regression], prepared.mechanism.parameters, method, settings, np.random.default_rng(0), lambda *_: None
    )
    np.testing.assert_allclose(estimate.parameters, THETA_HAT, rtol=1e-3)


def test_another_mechanism_has_no_such_form() -> None:
    bench = Rig(name="bench", mechanism="axes", axes=(Axis(),))
    with pytest.raises(BadInput, match="choose a method"):
        mechanisms.create(bench, "lagrange14")
