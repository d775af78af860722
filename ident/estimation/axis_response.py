"""Frequency response of one axis with the model fitted to it, and what they settle: delay, elasticity, or neither."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ident.data.frequency_response import FrequencyResponse, frequency_response
from ident.estimation.axis_model import AxisModel, fit_axis
from recordings.reader import read

DELAY_ACCURACY = 2e-4
"""Largest error of a delay [s], found with known ones; a smaller delay is none."""


@dataclass(frozen=True, eq=False)
class AxisResponse:
    """Estimate from one recording of `daq response`."""

    path: Path
    """The recording."""
    measured: FrequencyResponse
    model: AxisModel

    @property
    def bandwidth(self) -> float | None:
        """Lowest frequency at which the position follows with less than 1/sqrt(2) of the command [Hz]."""
        below = self.measured.frequency[abs(self.measured.loop) < 0.5**0.5]
        return float(below[0]) if len(below) else None

    @property
    def is_delayed(self) -> bool:
        """Whether the delay is larger than its accuracy."""
        return abs(self.model.delay) > DELAY_ACCURACY

    @property
    def conclusion(self) -> str:
        """One sentence about delay and elasticity."""
        model, smallest = self.model, f"{1000 * DELAY_ACCURACY:g} ms"
        late = f"{1000 * abs(model.delay):.2g} ms"
        delay = f"a delay of {late}" if model.delay > 0 else f"a torque that is reported {late} late"
        if model.resonance is not None:
            elasticity = f"elasticity (resonance at {model.resonance:.3g} Hz)"
            return f"Both {elasticity} and {delay}." if self.is_delayed else f"It is {elasticity}, not a delay."
        limit = f"no resonance up to {model.highest:.3g} Hz"
        if self.is_delayed:
            return f"It is {delay}, not elasticity: {limit}."
        return f"Neither a delay above {smallest} nor elasticity: {limit}."

    def as_json(self) -> dict[str, Any]:
        """Return the numbers as `ident response --json` prints them."""
        measured, model = self.measured, self.model
        return {
            "schema": 1,
            "joint": measured.joint,
            "rate": measured.rate,
            "bandwidth_hz": self.bandwidth,
            "inertia": model.inertia,
            "viscous": model.viscous,
            "delay": model.delay,
            "antiresonance_hz": model.antiresonance,
            "resonance_hz": model.resonance,
            "lines": model.lines,
            "highest_hz": model.highest,
            "misfit": model.misfit,
            "conclusion": self.conclusion,
        }


def axis_response(path: Path) -> AxisResponse:
    """Estimate the response of the joint that moves in the recording `path`.

    Raises:
        BadInput: it is no recording of `daq response`, or too few lines stand out of noise and friction.
    """
    measured = frequency_response(read(path))
    return AxisResponse(path, measured, fit_axis(measured))
