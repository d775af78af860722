"""Commands that heal a recording."""

from collections.abc import Sequence

import numpy as np

from ident.data_problems.arrangement import Arrangement
from recordings.data_problems import healing_command
from recordings.data_problems.signals import drive_signal
from recordings.recording import Recording


def mapping(recording: Recording, names: Sequence[str], arrangement: Arrangement) -> str:
    """The command that puts columns `names` ("drive" for what tells the torque) in another `arrangement`."""
    words = []
    for name in names:
        column = drive_signal(recording)[0] if name == "drive" else name
        if column == "velocity" and recording.velocity is None:
            continue
        # The torque of joint j stands in column order[j]; or the position of joint order[j] in column j.
        order = arrangement.order if name == "drive" else tuple(np.argsort(arrangement.order).tolist())
        for joint, (other, sign) in enumerate(zip(order, arrangement.signs, strict=True)):
            turned = sign < 0 and name == "drive"
            if joint != other or turned:
                unit = _unit(recording, column, joint)
                words += ["--map", f"{column}_{joint + 1}={column}_{other + 1}:{unit}{'*-1' if turned else ''}"]
    return healing_command(recording.path, words)


def _unit(recording: Recording, column: str, joint: int) -> str:
    position, effort = recording.rig.position_units[joint], recording.rig.effort_units[joint].replace(" ", "")
    return {"position": position, "velocity": f"{position}/s", "effort": effort, "voltage": "V"}[column]
