"""A small multisine on one joint while the others hold, to measure the frequency response of an axis."""

import math

import numpy as np

from recordings.recording import Floats
from recordings.rig import Limits, Rig
from trajectories import kinematics
from trajectories.motion import PlannedMotion, of_one_joint

PERIOD = 20.0
"""Duration of one repetition [s]. Long against the distance of the lines: what noise, quantisation and friction add
between the lines shows how much of it is on them."""
HIGHEST = 0.4
"""Highest frequency over the cycle rate."""
_LOWEST = 1.0
"""Lowest frequency [Hz]."""
_SPACING = 1.06
"""Ratio of neighbouring frequencies: a line within the width of a resonance with 3 % damping."""
_CORNERS = (2.0, 20.0)
"""Frequencies [Hz]: up to the first, all lines have the same amplitude, up to the second the same speed, and above it
the same acceleration, so that the highest lines stand out of the steps of the encoder and of friction."""
_SHARE = 0.7
"""Largest share of the speed and acceleration limits that the motion takes."""
_CENTRE = (0.0, 0.0)
_MAX_POINTS = 4000


def multisine(rig: Rig, joint: int, amplitude: float) -> PlannedMotion:
    """A multisine of `joint` (1 ... n) about the middle of the workspace, or about zero on single axes.

    `amplitude`: largest deviation [rad or m]; it is smaller where speed or acceleration would be large. Schroeder's
    phases make the lines add up to a small peak.

    Raises:
        BadInput: there is no such joint.
    """
    frequencies = lines(rig.rate)
    shape = np.prod([np.minimum(1.0, corner / frequencies) for corner in _CORNERS], axis=0)
    number = np.arange(1, len(frequencies) + 1)
    phases = -np.pi * number * (number - 1) / len(frequencies)
    shape *= _scale(frequencies, shape, phases, amplitude, rig.limits)
    pose = middle_pose(rig)

    def deviation(time: Floats) -> tuple[Floats, Floats, Floats]:
        position, velocity, acceleration = (_sum(time, frequencies, shape, phases, order) for order in range(3))
        return position, velocity, acceleration

    return PlannedMotion(
        name=f"response-{joint}",
        description=f"multisine on joint {joint}, {frequencies[0]:g} to {frequencies[-1]:g} Hz",
        space="joint",
        duration=PERIOD,
        periodic=True,
        definition=repr((joint, pose.tolist(), frequencies.tolist(), shape.tolist())),
        sample=of_one_joint(rig, joint, pose, deviation),
    )


def lines(rate: float) -> Floats:
    """Frequencies of the lines at a cycle rate [Hz]: whole multiples of 1 / PERIOD, evenly spaced on a log scale."""
    count = math.floor(math.log(HIGHEST * rate / _LOWEST) / math.log(_SPACING)) + 1
    return np.unique(np.rint(_LOWEST * PERIOD * _SPACING ** np.arange(count))) / PERIOD


def middle_pose(rig: Rig) -> Floats:
    """Pose (dof,) in the middle of the workspace, or about zero on single axes [rad or m]."""
    if rig.mechanism == "delta":
        middle = [*_CENTRE, sum(rig.limits.workspace_z) / 2]
        return kinematics.inverse(rig.geometry, np.array([middle]))[0]
    return np.full(rig.dof, min(max(0.0, rig.limits.joint_min), rig.limits.joint_max))


def _sum(time: Floats, frequencies: Floats, shape: Floats, phases: Floats, derivative: int) -> Floats:
    """Derivative of the sum of the sines at `time`, (n,)."""
    omega = 2 * np.pi * frequencies
    total = np.zeros(len(time))
    for begin in range(0, len(time), _MAX_POINTS):
        rows = slice(begin, begin + _MAX_POINTS)
        angle = np.outer(time[rows], omega) + phases + derivative * np.pi / 2
        total[rows] = np.sin(angle) @ (shape * omega**derivative)
    return total


def _scale(frequencies: Floats, shape: Floats, phases: Floats, amplitude: float, limits: Limits) -> float:
    """Factor of `shape` that keeps deviation, speed and acceleration within their limits."""
    time = np.arange(0.0, PERIOD, 1 / (10 * frequencies[-1]))
    largest = (amplitude, _SHARE * limits.speed, _SHARE * limits.acceleration)
    peaks = [np.max(np.abs(_sum(time, frequencies, shape, phases, derivative))) for derivative in range(3)]
    return float(min(limit / peak for limit, peak in zip(largest, peaks, strict=True)))
