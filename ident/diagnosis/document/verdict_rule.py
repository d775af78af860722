"""The verdict, as a pure function of what was measured."""

from dataclasses import dataclass

import numpy as np

from ident.diagnosis.document.document import Verdict
from ident.diagnosis.judge.improvement import MIN_SHARE
from recordings.recording import Floats

_DETECTABLE = 0.03
"""Share of the torque of a structured residual that an adequate model must not hide."""


@dataclass(frozen=True, eq=False)
class Remainder:
    """What the last model leaves, per joint."""

    rms: Floats
    """(dof,) [N m]"""
    floor: Floats
    """(dof,) noise floor [N m]."""
    limit: Floats
    """(dof,) error that a correct model leaves at most [N m]."""
    torque: Floats
    """(dof,) RMS of the torque [N m]."""
    structured: bool
    """Whether it repeats with the motion, is narrow-band, or trends in time; or, if nothing repeats, is no noise."""


def verdict_of(blocked: bool, left: Remainder, found: bool, taken: float) -> Verdict:
    """The verdict by the rules of the document, the first that applies.

    blocked: whether a data problem forbids any claim; found: whether an effect is missing; taken: share of the
    excess mean square that what was found has taken.
    """
    exceeds = bool((left.rms > left.limit).any())
    if blocked:
        return "implausible-data"
    if left.structured or (exceeds and found and taken < MIN_SHARE):
        return "unknown-structure"
    if found:
        return "missing-effect"
    detectable = bool((np.hypot(left.floor, _DETECTABLE * left.torque) > left.limit).all())
    return "adequate" if detectable and not exceeds else "undetermined"
