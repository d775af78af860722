"""What is found above the low-pass: waves over the angle, and waves over time."""

from dataclasses import dataclass

from ident.diagnosis.judge.improvement import Improvement


@dataclass(frozen=True)
class RippleLine:
    """One wave over the angle of one joint."""

    joint: int
    """From 0."""
    order: float
    """Periods per turn (per 2 pi m of a prismatic joint)."""
    sine: float
    """[N m], the mean of all directions and speeds."""
    cosine: float
    half_width: tuple[float, float, float]
    """Half the 95 % intervals of sine, cosine and order."""
    improvement: Improvement
    """On test rows above the low-pass, over all other lines."""
    same_frequency: float | None
    """Frequency of a vibration that explains as much [Hz]; None if none does."""

    @property
    def amplitude(self) -> float:
        """[N m]."""
        return float((self.sine**2 + self.cosine**2) ** 0.5)


@dataclass(frozen=True)
class Vibration:
    """A wave of one joint over time."""

    joint: int
    """From 0."""
    frequency: float
    """[Hz]"""
    amplitude: float
    """[N m]"""
