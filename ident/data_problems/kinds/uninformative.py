"""Noise that is as large as the torque: no model can be told from another, nor from none."""

import numpy as np

from ident.data_problems.facts import Facts
from recordings.data_problems import DataProblem

MAX_NOISE_SHARE = 0.5
"""Share of the torque's mean square that noise may have."""


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if the torque of a joint is mostly noise."""
    share = (facts.noise_rms / np.where(facts.torque_rms > 0, facts.torque_rms, np.inf)) ** 2
    joints = np.flatnonzero(share > MAX_NOISE_SHARE)
    if not len(joints):
        return None
    listing = ", ".join(f"{min(share[joint], 1.0):.0%} of joint {joint + 1}" for joint in joints)
    return DataProblem(
        kind="uninformative",
        joints=tuple(int(joint) + 1 for joint in joints),
        blocks=True,
        why=f"Noise makes up most of the torque's mean square ({listing}): such data cannot show anything.",
        remedy="Check how torque, current or voltage was measured; record a faster motion, or a less noisy signal.",
    )
