"""The verdict and its sentence, as pure functions of what was measured and found."""

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

    @property
    def exceeds(self) -> bool:
        """Whether it is more than a correct model leaves."""
        return bool((self.rms > self.limit).any())


def verdict_of(blocked: bool, left: Remainder, found: bool, taken: float) -> Verdict:
    """The verdict by the rules of the document, the first that applies.

    blocked: whether a data problem forbids any claim; found: whether an effect is missing; taken: share of the
    excess mean square that what was found has taken.
    """
    if blocked:
        return "implausible-data"
    if left.structured or (left.exceeds and found and taken < MIN_SHARE):
        return "unknown-structure"
    if found:
        return "missing-effect"
    detectable = bool((np.hypot(left.floor, _DETECTABLE * left.torque) > left.limit).all())
    return "adequate" if detectable and not left.exceeds else "undetermined"


def sentence_of(verdict: Verdict, left: Remainder, start: str, found: str, rest: str) -> str:
    """The `verdict` on effects that were searched in words.

    start: the model that lacks them; found: what was found, may be empty; rest: what is known of the rest.
    """
    lacks = f"{start} lacks {found}"
    if verdict == "adequate":
        return "No structured residual is left above the noise floor: the model is adequate for these recordings."
    if verdict == "missing-effect":
        return f"{lacks}. With this added, no structured residual is left above the noise floor."
    if verdict == "undetermined":
        reason = (
            "the error exceeds the noise floor, but nothing in it repeats with the motion"
            if left.exceeds
            else f"noise would hide a structured residual of {_DETECTABLE:.0%} of the torque"
        )
        return f"No missing effect was found, but one may be missing: {reason}."
    beyond = f"{lacks}. Beyond this, a" if found else "A"
    return f"{beyond} structured residual is left that no effect of the library explains: {rest}"
