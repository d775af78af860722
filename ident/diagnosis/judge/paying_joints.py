"""The joints on which an effect pays: pooled over joints, one on which it explains much carries all others."""

from collections.abc import Sequence

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import NONZERO_T
from ident.dynamics.structure import Term


def own_joints(term: Term) -> Sequence[int] | None:
    """Joints (from 0) whose error an effect answers for.

    None where it acts on the whole robot, or on a motion that moves the other joints' torque as well: it then answers
    for all that it changes.
    """
    return None if term.effect.whole_robot or term.effect.corrects_motion else term.joints


def paying_joints(before: FittedModel, after: FittedModel, index: int) -> tuple[int, ...]:
    """Joints (from 0) of the effect number `index` of `after` on which held-out rows get better by the minimum size.

    All of them where it does not act on joints alone. The size is a share of what the model `before`, which lacks the
    effect, leaves above the noise floor of that joint.
    """
    term = after.terms[index]
    if own_joints(term) is None:
        return term.joints
    return tuple(
        joint for joint in term.joints if after.improvement_in_turn(before, joints=[joint], required=NONZERO_T).pays
    )
