"""Motions that the robot follows exactly: a soft start, identical cycles, a soft end, on a fine grid of time."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.interpolate import make_interp_spline

from recordings.recording import Floats, Ints
from recordings.rig import Geometry
from trajectories import kinematics

Shape = Literal["fourier", "stations"]

FINE = 4000.0
"""About the rate of the fine grid [Hz]."""
_RAMP = 1.0
"""How long start and end take [s]."""
_REST = 0.25
"""Standing still before and after [s]."""
_LIVELY = 12.0
"""RMS acceleration of the joints, which the period is made for [rad/s^2]."""
_HARMONICS = 5
_PATH = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""Phase (m,), one cycle long from 0 to 1, to platform position and its first two derivatives by phase (m, 3)."""


@dataclass(frozen=True, eq=False)
class ReferenceMotion:
    """What the joints do. u unique rows hold start, one cycle and end; `rows` says which one when."""

    step: float
    """Of the fine grid [s]."""
    per_sample: int
    """Steps of the fine grid per sample of the recording."""
    theta: Floats
    """(u, 3) of the unique rows [rad]."""
    rate: Floats
    acceleration: Floats
    platform: Floats
    """(u, 3) [m]."""
    platform_rate: Floats
    rows: Ints
    """(n,) unique row at each instant of the fine grid."""
    repeat: Ints
    """(n,) cycle at each instant, -1 outside."""

    @property
    def time(self) -> Floats:
        """(n,) [s]."""
        return np.arange(len(self.rows), dtype=np.float64) * self.step


def draw(
    geometry: Geometry, shape: Shape, rng: np.random.Generator, *, rate: float, seconds: float
) -> ReferenceMotion:
    """A motion for a robot of that geometry, about `seconds` of identical cycles, recorded at `rate` [Hz]."""
    path = _fourier(geometry, rng) if shape == "fourier" else _stations(geometry, rng)
    per_sample = 2 * round(FINE / rate / 2)  # even: a sample's time lies evenly around its instant
    step = 1 / (rate * per_sample)
    period = round(_period(geometry, path) * rate) / rate
    cycles = max(round(seconds / period), 3)
    phase, speed, change = _timing(round(period / step), round(_RAMP / step), round(_REST / step), step)
    P, P1, P2 = path(np.mod(phase, 1.0))
    P_dot = P1 * speed[:, None]
    P_ddot = P2 * speed[:, None] ** 2 + P1 * change[:, None]
    theta = kinematics.inverse(geometry, P)
    theta_dot, theta_ddot = kinematics.joint_motion(geometry, theta, P, P_dot, P_ddot)
    before, cycle = round(_RAMP / step) + round(_REST / step), round(period / step)
    middle = np.arange(before, before + cycle)
    end = np.arange(before + cycle, len(phase))
    rows = np.concatenate([np.arange(before), np.tile(middle, cycles), end])
    repeat = np.concatenate([np.full(before, -1), np.repeat(np.arange(cycles), cycle), np.full(len(end), -1)])
    return ReferenceMotion(step, per_sample, theta, theta_dot, theta_ddot, P, P_dot, rows, repeat)


def _timing(cycle: int, ramp: int, rest: int, step: float) -> tuple[Floats, Floats, Floats]:
    """Phase, its speed [1/s] and acceleration of the unique rows; the start leads to phase 0, the end away from 1."""
    top = 1 / (cycle * step)
    u = np.arange(ramp) / ramp
    speed = top * (10 * u**3 - 15 * u**4 + 6 * u**5)
    change = top / (ramp * step) * (30 * u**2 - 60 * u**3 + 30 * u**4)
    phase = top * ramp * step * (2.5 * u**4 - 3 * u**5 + u**6 - 0.5)
    still = np.zeros(rest)
    return (
        np.concatenate(
            [still + phase[0], phase, np.arange(cycle) / cycle, [1.0], 1 - phase[:0:-1], 1 - still - phase[0]]
        ),
        np.concatenate([still, speed, np.full(cycle, top), [top], speed[:0:-1], still]),
        np.concatenate([still, change, np.zeros(cycle), [0.0], -change[:0:-1], still]),
    )


def _period(geometry: Geometry, path: _PATH) -> float:
    """Period [s] at which the joints are as lively as they should be: accelerations go with its inverse square."""
    P, P1, P2 = path(np.linspace(0, 1, 400, endpoint=False))
    theta = kinematics.inverse(geometry, P)
    _, acceleration = kinematics.joint_motion(geometry, theta, P, P1, P2)
    return float((np.mean(acceleration**2) ** 0.5 / _LIVELY) ** 0.5)


def _fourier(geometry: Geometry, rng: np.random.Generator) -> _PATH:
    """Sums of a few harmonics, as wide and as high as the robot likes."""
    scale = geometry.L1 / 0.3423
    order = np.arange(1, _HARMONICS + 1)
    a, b = rng.normal(size=(2, _HARMONICS, 3)) / order[:, None] ** 1.5

    def raw(phase: Floats) -> tuple[Floats, Floats, Floats]:
        omega = 2 * np.pi * order
        cos, sin = np.cos(np.outer(phase, omega)), np.sin(np.outer(phase, omega))
        return cos @ a + sin @ b, (cos * omega) @ b - (sin * omega) @ a, -(cos * omega**2) @ a - (sin * omega**2) @ b

    look = raw(np.linspace(0, 1, 400))[0]
    sideways, upwards = np.hypot(look[:, 0], look[:, 1]).max(), np.abs(look[:, 2]).max()
    size = scale * np.array([0.3 / sideways, 0.3 / sideways, 0.13 / upwards])
    centre = np.array([0.0, 0.0, -0.86 * geometry.L2])

    def path(phase: Floats) -> tuple[Floats, Floats, Floats]:
        P, P1, P2 = raw(phase)
        return centre + size * P, size * P1, size * P2

    return path


def _stations(geometry: Geometry, rng: np.random.Generator) -> _PATH:
    """Picking and placing between a few stations, lifted over the middle of each move."""
    scale = geometry.L1 / 0.3423
    count = 5
    angle = 2 * np.pi * (rng.permutation(count) + rng.uniform(-0.2, 0.2, count)) / count
    radius = rng.uniform(0.15, 0.29, count)
    stations = np.column_stack([radius * np.cos(angle), radius * np.sin(angle), rng.uniform(-0.82, -0.72, count)])
    lifted = 0.5 * (stations + np.roll(stations, -1, axis=0))
    lifted[:, 2] = rng.uniform(-0.66, -0.56, count)
    points = scale * np.stack([stations, lifted], axis=1).reshape(-1, 3)
    points[:, 2] *= geometry.L2 / (0.8 * scale)
    length = np.linalg.norm(np.diff(points, axis=0, append=points[:1]), axis=1)
    knots = np.concatenate([[0.0], np.cumsum(length**0.7)])
    spline = make_interp_spline(knots / knots[-1], np.vstack([points, points[:1]]), k=5, bc_type="periodic")
    first, second = spline.derivative(1), spline.derivative(2)
    return lambda phase: (spline(phase), first(phase), second(phase))
