"""Independent axes, revolute and prismatic, with and without weight."""

import numpy as np
import pytest

from ident.dynamics import mechanisms
from ident.dynamics.motion import Motion
from recordings.recording import Floats
from recordings.rig import Axis, Rig

RIG = Rig(name="bench", mechanism="axes", axes=(Axis(gravity=True), Axis(type="prismatic", gravity=True), Axis()))


@pytest.fixture(scope="module")
def motion() -> Motion:
    t = np.linspace(0, 2, 400)[:, None]
    omega = np.array([3.0, 4.0, 5.0])
    velocity = omega * np.cos(omega * t)
    return Motion(np.sin(omega * t), velocity, -(omega**2) * np.sin(omega * t), np.sign(velocity))


def torque(motion: Motion, **parameters: float) -> Floats:
    mechanism = mechanisms.create(RIG)
    values = dict.fromkeys((parameter.name for parameter in mechanism.parameters), 0.0) | parameters
    return mechanism.regressor(motion) @ np.array(list(values.values()))


def test_torque_is_newtons_law(motion: Motion) -> None:
    computed = torque(motion, I_1=0.2, c_v1=0.3, c_c1=0.4, G_c1=0.5, G_s1=0.6, m_2=7.0, c_v2=0.8, c_c2=0.9, G_2=1.1)
    q, v, a = motion.position, motion.velocity, motion.acceleration
    first = 0.2 * a[:, 0] + 0.3 * v[:, 0] + 0.4 * np.sign(v[:, 0]) + 0.5 * np.cos(q[:, 0]) + 0.6 * np.sin(q[:, 0])
    second = 7.0 * a[:, 1] + 0.8 * v[:, 1] + 0.9 * np.sign(v[:, 1]) + 1.1
    np.testing.assert_allclose(computed, np.stack([first, second, 0 * first], axis=1))
