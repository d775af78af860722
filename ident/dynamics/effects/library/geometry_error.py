"""Errors of the lengths in the rig file."""

from ident.dynamics.effects.base import Quantity, Signal, Values
from recordings.rig import Rig

LENGTHS = ("L1", "L2", "R")
"""Of the radii of base and platform only the difference matters, so that only R is changed."""


def true_rig(rig: Rig, values: Values) -> Rig:
    """Return `rig` with one length changed."""
    name, error = LENGTHS[round(float(values["which"][0]))], float(values["e"][0])
    geometry = rig.geometry.model_copy(update={name: getattr(rig.geometry, name) + error})
    return rig.model_copy(update={"geometry": geometry})


effect = Signal(
    sentence="A length of the robot is not what the rig file says.",
    size="{e} in number {which:n} of: 0 L1, 1 L2, 2 R - r",
    symptom="The residuals vary slowly with the platform's place, and with accelerations, in all joints.",
    causes="a drawing in place of a measurement, another gripper flange, forearms of another batch",
    remedy="measure arms, forearms and radii from joint centre to joint centre, and correct the rig file",
    record="motion to the edges of the workspace, high and low, slowly and fast",
    equation="length = length in the rig file + e; which: 0 arms L1, 1 forearms L2, 2 radii R - r",
    axis="position",
    mechanisms=("delta",),
    whole_robot=True,
    parameters=(
        Quantity(
            name="e",
            unit="m",
            meaning="what the length is too long",
            lower=-0.12,
            upper=0.12,
            initial_guesses=(0.002,),
        ),
    ),
    shapes=(
        Quantity(
            name="which",
            unit="1",
            meaning="0 L1, 1 L2, 2 R - r",
            lower=0,
            upper=2,
            initial_guesses=(0.0, 1.0, 2.0),
            searched=False,
        ),
    ),
    rig=true_rig,
    bodies=(),
)
