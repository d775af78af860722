"""The one judge: whether a model with one more effect is accepted in place of the model without it, and on what
evidence. Every sentence uses its record."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import MIN_SHARE, MIN_T, Improvement
from ident.diagnosis.judge.paying_joints import own_joints, paying_joints
from ident.diagnosis.judge.price import is_significant
from ident.diagnosis.judge.rules import OF_INTERVALS, OF_VALUES, objection
from ident.diagnosis.split.split_data import rms

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
    band_hz: tuple[float, float] | None = None
    """Of a ripple above the low-pass: the band in which it stands, and in which it was judged."""
    rms_before: tuple[float, ...] | None = None
    """In that band, per joint: held-out error of the model without the ripple [N m]."""
    rms_after: tuple[float, ...] | None = None
    """With it."""


@dataclass(frozen=True)
class Rejection:
    """Why an effect of the library is not among the findings; the evidence beside the last model."""

    status: RejectionStatus
    why: str
    evidence: Evidence | None = None
    """None where it was not tested."""


@dataclass(frozen=True)
class Judgement:
    """What the judge says of one effect."""

    accepted: bool
    evidence: Evidence
    reason: str = ""
    """Why it is not accepted: ends the sentence "It would explain …, but …"."""
    refuted: bool = False
    """Whether something speaks against it; otherwise it is only not confirmed."""

    @property
    def likely(self) -> bool:
        """Whether the evidence speaks for the effect, but the held-out rows lack the power to confirm it."""
        interval = self.evidence.gain_ci95
        return (
            self.evidence.decided_by == "held-out" and not self.accepted and interval is not None and interval[0] > 0
        )

    def rejection(self, otherwise: str) -> Rejection:
        """Why it is no finding; `otherwise`: the reason if the judge would accept it."""
        status: RejectionStatus = "refuted" if self.refuted else "not-confirmed"
        gain, why = self.evidence.gain, self.reason or otherwise
        left = f"It would explain {gain:.1%} of what is left above the noise floor on held-out data, but {why}."
        worse = f"Held-out data get no better by it, and {why}."
        return Rejection(status, left if round(gain, 3) > 0 else worse, self.evidence)


def judge(before: FittedModel, after: FittedModel, index: int, compared: int = 1) -> Judgement:
    """Judge the effect number `index` of `after`, fitted as `before` without it.

    compared: number of models among which the held-out rows chose this one; the interval allows for it.
    """
    index %= len(after.terms)
    term, blocks = after.terms[index], after.blocks_over(before)
    own = own_joints(term)
    improvement = blocks.improvement(compared, own)

    def judgement(decided_by: str, reason: str = "", refuted: bool = False) -> Judgement:
        return Judgement(not reason, evidence_of(improvement, decided_by), reason, refuted)

    if found := objection(OF_VALUES, before, after, index):
        return judgement(*found, refuted=True)
    if not _shows_in_training(before, after, term.joints):
        return judgement("training", "the rows of the fit show no more of it than chance would")
    if improvement.is_small:
        reason = f"that is less than {MIN_SHARE:.0%}: negligible beside what else is missing"
        return judgement("size", reason, refuted=improvement.interval[1] < MIN_SHARE)
    improvement = after.improvement_in_turn(before, compared, own)
    if not improvement.is_supported:
        reason = f"held-out data do not confirm it: t is {improvement.t:.1f} where {MIN_T} is required"
        return judgement("held-out", reason)
    if idle := {*term.joints}.difference(paying_joints(before, after, index)):
        reason = f"on joint {min(idle) + 1} it explains less than {MIN_SHARE:.0%}, or no more than chance would"
        return judgement("joints", reason)
    if blocks.improvement(joints=range(len(blocks.floor))).reduction <= 0:
        return judgement("joints", "the other joints get worse by more than its own get better")
    if found := objection(OF_INTERVALS, before, after, index):
        return judgement(*found)
    return judgement("held-out")


def _shows_in_training(before: FittedModel, after: FittedModel, joints: Sequence[int]) -> bool:
    """Whether the loss falls by more than the parameters are worth, the residual by more than preprocessing leaves.

    joints: those of the effect, from 0, taken together: an effect that smooths changes each of them a little.
    """
    split, parameters = after.split, len(after.solution.x) - len(before.solution.x)
    changed = [b - a for b, a in zip(before.residuals, after.residuals, strict=True)]
    size = rms(changed, [np.isfinite(change) for change in changed])
    matters = np.linalg.norm(size[list(joints)]) > np.linalg.norm(after.noise_floor.least[list(joints)])
    return bool(matters) and is_significant(
        before.solution.loss, after.solution.loss, parameters, split.independent_rows
    )


def evidence_of(improvement: Improvement, decided_by: str = "held-out") -> Evidence:
    """The record of an `improvement` on held-out rows."""
    from scipy.special import ndtr

    return Evidence(
        improvement.share,
        decided_by,
        gain_ci95=improvement.interval,
        t=improvement.t,
        t_required=MIN_T,
        power=float(ndtr(improvement.t - MIN_T)),
    )
