"""Motions as Fourier series, and their TOML files."""

import json
from typing import Literal, Self

import numpy as np
from pydantic import model_validator

from recordings.config import ConfigSection, Positive
from recordings.recording import Floats
from trajectories.motion import PlannedMotion, Space

Coefficients = tuple[float, ...]


class FourierSeries(ConfigSection):
    """Fourier series of m harmonics per axis.

    x(t) = centre + sum over h = 1 ... m of cosine_h cos(2 pi h t / period) + sine_h sin(2 pi h t / period)

    The axes are x, y, z [m] or the joints [rad or m]. A trajectory file holds these keys.
    """

    kind: Literal["fourier"]
    space: Space
    period: Positive
    """Duration of one repetition [s]."""
    centre: tuple[float, ...]
    cosine: tuple[Coefficients, ...]
    """Coefficients of harmonics 1 ... m, one list per axis."""
    sine: tuple[Coefficients, ...]
    """Coefficients of harmonics 1 ... m, one list per axis."""
    description: str = "Fourier series"

    @model_validator(mode="after")
    def _check_axes(self) -> Self:
        counts = [len(self.centre), len(self.cosine), len(self.sine)]
        if len(set(counts)) > 1 or (self.space == "platform" and counts[0] != 3) or counts[0] == 0:
            number = "three axes (x, y, z)" if self.space == "platform" else "equally many joints"
            raise ValueError(f"centre, cosine and sine: {number} in each expected, {counts} found")
        return self

    @model_validator(mode="after")
    def _check_harmonics(self) -> Self:
        counts = [len(axis) for axis in (*self.cosine, *self.sine)]
        if min(counts) == 0 or len(set(counts)) > 1:
            raise ValueError(
                f"cosine and sine: lists all of one length (the number of harmonics) expected, lengths {counts} found"
            )
        return self

    def sample(self, phase: Floats) -> tuple[Floats, Floats, Floats]:
        """Position, first and second derivative, each (m, 3), at phase time (m,) [s]."""
        cosine, sine = np.array(self.cosine).T, np.array(self.sine).T
        omega = 2 * np.pi / self.period * np.arange(1, len(cosine) + 1)
        cos, sin = np.cos(np.outer(phase, omega)), np.sin(np.outer(phase, omega))
        position: Floats = np.array(self.centre) + cos @ cosine + sin @ sine
        velocity: Floats = (cos * omega) @ sine - (sin * omega) @ cosine
        acceleration: Floats = -(cos * omega**2) @ cosine - (sin * omega**2) @ sine
        return position, velocity, acceleration

    def as_toml(self) -> str:
        """Format the series as a trajectory file."""
        # Numbers, strings and lists of them have the same syntax in JSON and TOML.
        lines = [f"{key} = {json.dumps(value)}" for key, value in self.model_dump(mode="json").items()]
        return "\n".join(lines) + "\n"

    def motion(self, name: str) -> PlannedMotion:
        """Convert the series to a motion."""
        return PlannedMotion(
            name=name,
            description=self.description,
            space=self.space,
            duration=self.period,
            periodic=True,
            definition=self.model_dump_json(exclude={"description"}),
            sample=self.sample,
        )
