"""Weight on a revolute axis, which the rig file does not declare."""

import numpy as np

from ident.dynamics.effects.base import Additive, Quantity
from recordings.rig import Rig


def impossible(rig: Rig, joint: int) -> str | None:
    """Weight is in the model already, or does not depend on the position."""
    axis = rig.axes[joint]
    if axis.gravity:
        return "The rig file declares the weight (gravity = true), so it is in the model."
    return "On a prismatic joint weight is a torque_offset." if axis.type == "prismatic" else None


effect = Additive(
    sentence="The axis carries a weight that the rig file does not declare.",
    size="{norm}",
    symptom="The residual follows sine and cosine of the joint's angle, standing or moving.",
    causes="an arm or tool on an axis that is not vertical",
    remedy="write gravity = true for this axis in the rig file, or import with --gravity",
    record="the axis slowly through at least half a turn, in both directions",
    axis="position",
    mechanisms=("axes",),
    impossible=impossible,
    formula=lambda q: (np.sin(q), np.cos(q)),
    parameters=(
        Quantity(name="a", unit="{effort}", meaning="weight times lever that goes with the sine"),
        Quantity(name="b", unit="{effort}", meaning="weight times lever that goes with the cosine"),
    ),
    on_arm=True,
)
