"""Excitation path: many frequencies at once in all three axes."""

import numpy as np

from recordings.recording import Floats
from trajectories.fourier import Coefficients, FourierSeries
from trajectories.motion import PlannedMotion

PERIOD = 5.0
CENTRE = (0.0, 0.0, -0.68)
HARMONICS = np.arange(1, 11)
AMPLITUDE = np.array([0.16, 0.16, 0.08])
"""Amplitude of the first harmonic [m]; harmonic h has 1 / h of it, so that all have equal speed."""
START_PHASE = np.array([0.0, 2.1, 4.2])
"""Phase of each axis, which decorrelates the axes [rad]."""


def motion() -> PlannedMotion:
    """Build ten harmonics with Schroeder phases, which give a low crest factor."""
    schroeder = np.pi * HARMONICS * (HARMONICS - 1) / len(HARMONICS)
    phase = START_PHASE[:, None] * HARMONICS + schroeder
    amplitude = AMPLITUDE[:, None] / HARMONICS
    return FourierSeries(
        kind="fourier",
        description="Fourier series of ten harmonics in all three axes",
        space="platform",
        period=PERIOD,
        centre=CENTRE,
        cosine=_axes(amplitude * np.cos(phase)),
        sine=_axes(amplitude * np.sin(phase)),
    ).motion("excitation")


def _axes(coefficients: Floats) -> tuple[Coefficients, Coefficients, Coefficients]:
    x, y, z = (tuple(axis) for axis in coefficients.tolist())
    return x, y, z
