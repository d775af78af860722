"""What must hold in every cycle; the first thing that does not, ends the run."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from drivers.protocol import Power, Sample
from recordings.rig import Rig

MAX_SILENCE = 5
"""Cycles in a row in which a drive may stay silent."""


class Supervisor:
    """Looks at one sample after the other. Every check returns the reason to stop, or None."""

    def __init__(self, rig: Rig) -> None:
        self._limits = rig.limits
        self._silent = [0] * rig.dof
        self.worst_following_error = 0.0

    def drives(self, sample: Sample) -> str | None:
        """Drive faults and silence."""
        if sample.trouble is not None:
            return sample.trouble
        for j, position in enumerate(sample.position):
            self._silent[j] = self._silent[j] + 1 if math.isnan(position) else 0
            if self._silent[j] >= MAX_SILENCE:
                return f"joint {j + 1}: no answer for {MAX_SILENCE} cycles; check the cable and the drive"
        return None

    def motion(self, sample: Sample, due: NDArray[np.float64] | Sequence[float]) -> str | None:
        """While the drives follow: `due` is the target [rad] that this sample's position should have reached."""
        for j, (position, target) in enumerate(zip(sample.position, due, strict=True)):
            error = abs(position - target)
            if error > self.worst_following_error:
                self.worst_following_error = error
            if error > self._limits.following_error:
                return (
                    f"joint {j + 1}: following error {error:.4f} rad, limit {self._limits.following_error:g} rad; "
                    "look for a collision, too fast a motion or a wrong zero_offset, gear or sign"
                )
            if sample.power[j] is not Power.ON:
                return f"joint {j + 1}: the drive left operation by itself (now {sample.power[j].value})"
        return None
