"""The joints on which an effect pays: pooled over joints, one on which it explains much carries all others."""

from collections.abc import Sequence

from ident.diagnosis.judge.improvement import Blocks
from ident.dynamics.structure import Term


def own_joints(term: Term) -> Sequence[int] | None:
    """Joints (from 0) whose error an effect answers for.

    None where it acts on the whole robot, or on a motion that moves the other joints' torque as well: it then answers
    for all that it changes.
    """
    return None if term.effect.whole_robot or term.effect.corrects_motion else term.joints


def paying_joints(term: Term, blocks: Blocks) -> tuple[int, ...]:
    """Joints (from 0) of a `term` on which held-out rows get better by the minimum size.

    All of them where it does not act on joints alone. The size is a share of what the model without the term leaves
    above the noise floor of that joint.

    blocks: of the model with the term over the model without it.
    """
    if own_joints(term) is None:
        return term.joints
    return tuple(joint for joint in term.joints if blocks.improvement(joints=[joint]).pays)
