"""Motion that is too short to tell the parameters of a joint."""

import numpy as np

from recordings.data_problems import DataProblem
from recordings.data_problems.signals import of_motion
from recordings.recording import Recording

MIN_SECONDS = 0.5
"""Duration of a motion whose torque, within 30 Hz, has ten independent values for each of the three parameters that a
joint has of its own."""


def find(recording: Recording) -> DataProblem | None:
    """Return the problem if the motion lasts less than half a second."""
    time = recording.time[of_motion(recording)]
    seconds = float(np.ptp(time)) if len(time) else 0.0
    if seconds >= MIN_SECONDS or len(time) < 2:
        return None
    return DataProblem(
        kind="too-short",
        joints=(),
        blocks=True,
        why=f"The motion lasts {seconds:.2g} s: it has fewer independent values than the model has parameters.",
        remedy="Record some seconds of motion, with several speeds in both directions.",
    )
