"""What the kinds of data problems look at."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ident.data import noise
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
        return _rms([each.torque for each in self.recordings])

    @cached_property
    def noise_rms(self) -> Floats:
        """(dof,) of the noise in the torque [N m or N]."""
        residuals = [each.torque - each.regressor @ self.arrangements.parameters for each in self.recordings]
        of_joints = noise.estimate(self.recordings, residuals)
        stds = [
            np.stack([joint.torque_std(each.volt_sensitivity[:, j]) for j, joint in enumerate(of_joints)], axis=1)
            for each in self.recordings
        ]
        return _rms([np.where(each.usable, std, np.nan) for each, std in zip(self.recordings, stds, strict=True)])


def _rms(values: Sequence[Floats]) -> Floats:
    return np.sqrt(np.nanmean(np.concatenate(values) ** 2, axis=0))
