"""Validation path, in the role of Fig. 5b: a five-pointed rosette, drawn while rising and falling."""

from trajectories.fourier import FourierSeries
from trajectories.motion import PlannedMotion


def motion() -> PlannedMotion:
    """Build the rosette from two circles in opposite directions: contouring, unlike the pick and place of fig5a.

    The figure gives no coordinates; these values are our own.
    """
    return FourierSeries(
        kind="fourier",
        description="five-pointed rosette, rising and falling (validation)",
        space="platform",
        period=3.0,
        centre=(0.02, -0.01, -0.68),
        cosine=((0.0, 0.15, 0.13, 0.0), (0.0, 0.0, 0.0, 0.0), (0.03, 0.0, 0.0, 0.035)),
        sine=((0.0, 0.0, 0.0, 0.0), (0.0, 0.15, -0.13, 0.0), (0.06, 0.0, 0.0, 0.0)),
    ).motion("fig5b")
