"""Reference motions with smooth start, identical cycles and smooth end, on a fine time grid."""

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
"""Approximate rate of the fine grid [Hz]."""
_RAMP = 1.0
"""Duration of start and end [s]."""
_REST = 0.25
"""Standstill before and after the motion [s]."""
_RMS_ACCELERATION = 12.0
"""RMS acceleration of the joints, which determines the period [rad/s^2]."""
_HARMONICS = 5
_PHASES = 400
"""Phases at which size and acceleration of a path are evaluated, per move."""
_PATH = Callable[[Floats], tuple[Floats, Floats, Floats]]
"""Function of the phase (m,), 0 to 1 per cycle: platform position and its first two derivatives by phase (m, 3)."""


@dataclass(frozen=True, eq=False)
class ReferenceMotion:
    """Motion of the joints. u unique rows contain start, one cycle and end; `rows` maps instants to them."""

    step: float
    """Step of the fine grid [s]."""
    per_sample: int
    """Steps of the fine grid per sample of the recording."""
    theta: Floats
    """(u, 3) joint angles of the unique rows [rad]."""
    rate: Floats
    acceleration: Floats
    platform: Floats
    """(u, 3) platform positions [m]."""
    platform_rate: Floats
    rows: Ints
    """(n,) index of the unique row at each instant of the fine grid."""
    repeat: Ints
    """(n,) number of the cycle at each instant, -1 outside of cycles."""

    @property
    def time(self) -> Floats:
        """(n,) instants [s]."""
        return np.arange(len(self.rows), dtype=np.float64) * self.step


def draw(
    geometry: Geometry,
    shape: Shape,
    rng: np.random.Generator,
    *,
    rate: float,
    seconds: float,
    cycles: int | None = None,
    repeats: bool = True,
) -> ReferenceMotion:
    """Random motion with about `seconds` of identical cycles, for recordings at `rate` [Hz].

    cycles: their number; None: as many as the usual acceleration allows. repeats: False for one long cycle of
    different moves.
    """
    draw_path = _fourier if shape == "fourier" else _stations
    path = draw_path(geometry, rng, 1)
    period = _period(geometry, path, 1)
    if not repeats:
        moves, cycles = max(round(seconds / period), 3), 1
        path = draw_path(geometry, rng, moves)
        period = _period(geometry, path, moves)
    elif cycles:
        period = seconds / cycles
    per_sample = 2 * round(FINE / rate / 2)  # even: the averaging window of a sample is symmetric
    step = 1 / (rate * per_sample)
    period = round(period * rate) / rate
    cycles = cycles or max(round(seconds / period), 3)
    phase, phase_speed, phase_acceleration = _timing(
        round(period / step), round(_RAMP / step), round(_REST / step), step
    )
    P, P1, P2 = path(np.mod(phase, 1.0))
    P_dot = P1 * phase_speed[:, None]
    P_ddot = P2 * phase_speed[:, None] ** 2 + P1 * phase_acceleration[:, None]
    theta = kinematics.inverse(geometry, P)
    theta_dot, theta_ddot = kinematics.joint_motion(geometry, theta, P, P_dot, P_ddot)
    before, cycle = round(_RAMP / step) + round(_REST / step), round(period / step)
    middle = np.arange(before, before + cycle)
    end = np.arange(before + cycle, len(phase))
    rows = np.concatenate([np.arange(before), np.tile(middle, cycles), end])
    repeat = np.concatenate([np.full(before, -1), np.repeat(np.arange(cycles), cycle), np.full(len(end), -1)])
    return ReferenceMotion(step, per_sample, theta, theta_dot, theta_ddot, P, P_dot, rows, repeat)


def _timing(cycle: int, ramp: int, rest: int, step: float) -> tuple[Floats, Floats, Floats]:
    """Phase, its first [1/s] and second derivative in the unique rows; the start ends at 0, the end begins at 1."""
    top = 1 / (cycle * step)
    u = np.arange(ramp) / ramp
    phase_speed = top * (10 * u**3 - 15 * u**4 + 6 * u**5)
    phase_acceleration = top / (ramp * step) * (30 * u**2 - 60 * u**3 + 30 * u**4)
    phase = top * ramp * step * (2.5 * u**4 - 3 * u**5 + u**6 - 0.5)
    still = np.zeros(rest)
    return (
        np.concatenate(
            [still + phase[0], phase, np.arange(cycle) / cycle, [1.0], 1 - phase[:0:-1], 1 - still - phase[0]]
        ),
        np.concatenate([still, phase_speed, np.full(cycle, top), [top], phase_speed[:0:-1], still]),
        np.concatenate([still, phase_acceleration, np.zeros(cycle), [0.0], -phase_acceleration[:0:-1], still]),
    )


def _period(geometry: Geometry, path: _PATH, moves: int) -> float:
    """Period [s] for the desired RMS acceleration, which is proportional to its inverse square."""
    P, P1, P2 = path(np.linspace(0, 1, _PHASES * moves, endpoint=False))
    theta = kinematics.inverse(geometry, P)
    _, acceleration = kinematics.joint_motion(geometry, theta, P, P1, P2)
    return float((np.mean(acceleration**2) ** 0.5 / _RMS_ACCELERATION) ** 0.5)


def _fourier(geometry: Geometry, rng: np.random.Generator, moves: int) -> _PATH:
    """Sum of harmonics, scaled to the workspace of the robot; the lowest has `moves` periods per cycle."""
    scale = geometry.L1 / 0.3423
    order = np.arange(moves, moves * _HARMONICS + 1)
    a, b = rng.normal(size=(2, len(order), 3)) / (order[:, None] / moves) ** 1.5

    def raw(phase: Floats) -> tuple[Floats, Floats, Floats]:
        omega = 2 * np.pi * order
        cos, sin = np.cos(np.outer(phase, omega)), np.sin(np.outer(phase, omega))
        return cos @ a + sin @ b, (cos * omega) @ b - (sin * omega) @ a, -(cos * omega**2) @ a - (sin * omega**2) @ b

    samples = raw(np.linspace(0, 1, _PHASES * moves))[0]
    sideways, upwards = np.hypot(samples[:, 0], samples[:, 1]).max(), np.abs(samples[:, 2]).max()
    size = scale * np.array([0.3 / sideways, 0.3 / sideways, 0.13 / upwards])
    centre = np.array([0.0, 0.0, -0.86 * geometry.L2])

    def path(phase: Floats) -> tuple[Floats, Floats, Floats]:
        P, P1, P2 = raw(phase)
        return centre + size * P, size * P1, size * P2

    return path


def _stations(geometry: Geometry, rng: np.random.Generator, moves: int) -> _PATH:
    """Pick-and-place motion between stations, five per `moves`, lifted on the way from each to the next."""
    scale = geometry.L1 / 0.3423
    count = 5 * moves
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
