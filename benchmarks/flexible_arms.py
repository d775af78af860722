"""Arms behind springs or gaps, by MuJoCo's forward dynamics, their motors moved as prescribed.

Other joints follow their motors. A gap ends at stiff, damped stops, which push and do not pull.
"""

from collections.abc import Callable, Sequence

import mujoco
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.ndimage import uniform_filter1d

from recordings.recording import Floats

_STEPS_PER_SECOND = 2000
_SPRING_DAMPING, _STOP_DAMPING = 0.04, 0.5
"""Over the critical damping of the joint alone."""
_STOP_FREQUENCY = 100.0
"""Natural frequency of an arm that lies on a stop [Hz]."""
_SETTLING, _DRAG = 1000, 0.9
"""Steps in which arms come to rest before their motors move, and the share of their speed that they keep in each."""
Coupling = Callable[[Floats, Floats], Floats]
"""Computes the torque (f,) from motor to arm of the twist (f,) and its rate (f,)."""


def spring(softness: Floats | float, inertia: Floats) -> Coupling:
    """Springs of arms with this `inertia` (f,) [kg m^2]; softness: 1 over the square of their frequency [s^2].

    None is stiffer than a stop.
    """
    stiffness = inertia / np.maximum(softness, (2 * np.pi * _STOP_FREQUENCY) ** -2)
    damping = 2 * _SPRING_DAMPING * np.sqrt(inertia * stiffness)
    return lambda twist, rate: stiffness * twist + damping * rate


def gap(half: float, inertia: Floats) -> Coupling:
    """Gaps of +-`half` [rad] before arms with this `inertia` (f,) [kg m^2]."""
    omega = 2 * np.pi * _STOP_FREQUENCY
    stiffness, damping = inertia * omega**2, 2 * _STOP_DAMPING * inertia * omega

    def push(twist: Floats, rate: Floats) -> Floats:
        side = np.sign(twist)
        depth = np.abs(twist) - half
        return np.where(depth > 0, side * np.maximum(stiffness * depth + damping * side * rate, 0.0), 0.0)

    return push


def arm_torque(
    model: mujoco.MjModel,
    time: Floats,
    motors: Sequence[Floats],
    soft: Sequence[int],
    make: Callable[[Floats], Coupling],
) -> Floats:
    """Torque (n, dof) between motors and arms, means of samples at the instants `time` (n,).

    motors: their position, velocity and acceleration (n, dof) there; soft: (f,) joints (from 0) behind the coupling
    that `make` returns for the inertia (f,) of the arms, the others of these joints loose and the rest at rest.
    """
    data, joints = mujoco.MjData(model), np.array(soft)
    per_sample = round(_STEPS_PER_SECOND * (time[1] - time[0]))
    fine = np.linspace(time[0], time[-1], per_sample * (len(time) - 1) + 1)
    q, v, a = (CubicSpline(time, signal)(fine) for signal in motors)
    q, v, a = (
        np.concatenate([np.tile(share * each[:1], (_SETTLING, 1)), each]) for share, each in ((1, q), (0, v), (0, a))
    )
    inertia, torque, h = np.zeros((model.nv, model.nv)), np.empty_like(q), fine[1] - fine[0]
    at, speed = q[0, joints].copy(), v[0, joints].copy()
    couple: Coupling | None = None
    for k in range(len(q)):
        data.qpos[:], data.qvel[:] = q[k], v[k]
        data.qpos[joints], data.qvel[joints] = at, speed
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mujoco.mj_fullM(model, data, inertia)
        own = inertia[np.ix_(joints, joints)]
        couple = couple or make(1 / np.diag(np.linalg.inv(own)))
        pushed, acceleration = couple(q[k, joints] - at, v[k, joints] - speed), a[k].copy()
        acceleration[joints] = 0.0
        needed = inertia @ acceleration + data.qfrc_bias
        acceleration[joints] = np.linalg.solve(own, pushed - needed[joints])
        torque[k] = inertia @ acceleration + data.qfrc_bias
        speed = (speed + h * acceleration[joints]) * (_DRAG if k < _SETTLING else 1.0)
        at += h * speed
    return uniform_filter1d(torque, per_sample + 1, axis=0)[_SETTLING::per_sample]
