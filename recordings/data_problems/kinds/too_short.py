"""Motion that is too short to tell the parameters of a joint."""

import numpy as np

from recordings.data_problems import DataProblem
from recordings.data_problems.signals import FASTEST, of_motion
from recordings.recording import Recording

MIN_VALUES = 30
"""Independent values of a torque: ten for each of the three parameters that a joint has of its own."""
_BANDWIDTH, _SHARE = 30.0, 0.2
"""A low-pass leaves two of them per period of its cut-off: of 30 Hz, or of the share of a low rate [Hz]."""


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if the motion has too few independent values: it lasts less than half a second, or more at
    a rate below 150 Hz."""
    time = recording.time[of_motion(recording)]
    if len(time) < 2:
        return None
    seconds, rate = float(np.ptp(time)), 1 / float(np.median(np.diff(time)))
    shortest = MIN_VALUES / (2 * min(_BANDWIDTH, _SHARE * rate))
    if seconds >= shortest or rate > FASTEST:
        return None
    return DataProblem(
        kind="too-short",
        joints=(),
        blocks=True,
        why=f"The motion lasts {seconds:.2g} s. At {rate:.3g} Hz the parameters need {shortest:.2g} s or more.",
        remedy="Record some seconds of motion, with several speeds in both directions.",
    )
