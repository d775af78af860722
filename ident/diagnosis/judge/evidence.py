"""The record of the evidence for one effect beside one model: made by the judge, and used by every sentence."""

from dataclasses import dataclass
from typing import Literal

RejectionStatus = Literal["refuted", "not-confirmed", "not-tested", "not-observable", "absorbed"]


@dataclass(frozen=True)
class Evidence:
    """What held-out rows say of one effect beside one model."""

    gain: float
    """Share by which the held-out mean square above the noise floor falls; an upper bound where screening decided."""
    decided_by: str
    """The rule that decided: `screening`, `held-out`, …"""
    gain_ci95: tuple[float, float] | None = None
    t: float | None = None
    """Student's t of the reduction over independent blocks."""
    t_required: float | None = None
    power: float | None = None
    """Probability that these held-out rows would confirm a gain of this size, 0 to 1."""


@dataclass(frozen=True)
class Rejection:
    """Why an effect of the library is not among the findings; the evidence beside the last model."""

    status: RejectionStatus
    why: str
    evidence: Evidence | None = None
    """None where it was not tested."""
