"""What the kinds of data problems look at."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.data_problems.arrangement import Arrangements
from recordings.recording import Floats


@dataclass(frozen=True, eq=False)
class Facts:
    """Recordings as every model reads them."""

    recordings: Sequence[PreparedRecording]

    @cached_property
    def arrangements(self) -> Arrangements:
        """Fits of the mechanism with other signs and orders of the joints."""
        return Arrangements(self.recordings)

    @cached_property
    def torque_rms(self) -> Floats:
        """(dof,) within the analysis band [N m or N]."""
        return np.sqrt(np.nanmean(np.concatenate([each.torque for each in self.recordings]) ** 2, axis=0))
