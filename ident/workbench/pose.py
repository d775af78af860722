"""Positions of the parts of a delta robot over the time of a recording."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from ident.workbench.views import RecordingView, TorqueSeries
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

STEP = 0.05
"""Time between two poses [s]."""
_SMALL_RESIDUAL_COLOUR, _LARGE_RESIDUAL_COLOUR = (138, 148, 156), (213, 94, 0)
"""RGB colours of a limb with the smallest and the largest residual."""


@dataclass(frozen=True, eq=False)
class PoseSequence:
    """Poses of the three limbs at n instants."""

    time: Floats
    """[s]."""
    platform: Floats
    """(n, 3) [m]."""
    shoulders: Floats
    """(3 limbs, 3) [m]."""
    elbows: Floats
    """(n, 3 limbs, 3) [m]."""
    platform_joints: Floats
    """(n, 3 limbs, 3) joints between forearms and platform [m]."""
    residual_share: Floats
    """(n, 3 limbs) magnitude of the residual relative to its 98 % quantile, 0 to 1."""

    def colour(self, i: int, limb: int) -> str:
        """Return the colour of `limb` (from 0) at the instant `i`."""
        share = float(self.residual_share[i, limb])
        return "#" + "".join(
            f"{round(a + share * (b - a)):02x}"
            for a, b in zip(_SMALL_RESIDUAL_COLOUR, _LARGE_RESIDUAL_COLOUR, strict=True)
        )

    @staticmethod
    def cylinder_rotation(start: Floats, end: Floats) -> list[list[float]]:
        """Return the rotation matrix that turns a cylinder along y into the direction from `start` to `end` (3,)."""
        rotation, _ = Rotation.align_vectors(end - start, [0.0, 1.0, 0.0])
        matrix: list[list[float]] = rotation.as_matrix().tolist()
        return matrix


def pose_sequence(view: RecordingView, geometry: Geometry, series: TorqueSeries | None) -> PoseSequence:
    """Compute the poses of the delta robot in `view`; `series` gives the residuals that colour the limbs."""
    position = view.signals["position"][1].astype(float)
    valid_rows = np.flatnonzero(np.isfinite(position).all(axis=1))
    sample_times = np.arange(view.time[valid_rows[0]], view.time[valid_rows[-1]], STEP)
    rows = valid_rows[np.minimum(np.searchsorted(view.time[valid_rows], sample_times), len(valid_rows) - 1)]
    theta = position[rows]
    platform = kinematics.forward(geometry, theta)
    phi = np.array(geometry.phi)
    directions = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)
    elbows = (geometry.R + geometry.L1 * np.cos(theta))[:, :, None] * directions
    elbows[:, :, 2] = geometry.L1 * np.sin(theta)
    return PoseSequence(
        time=view.time[rows],
        platform=platform,
        shoulders=geometry.R * directions,
        elbows=elbows,
        platform_joints=platform[:, None, :] + geometry.r * directions,
        residual_share=_residual_share(series, view.time[rows]),
    )


def _residual_share(series: TorqueSeries | None, time: Floats) -> Floats:
    if series is None:
        return np.zeros((len(time), 3))
    magnitude = np.abs(series.residual)
    largest = np.nanquantile(magnitude, 0.98)
    rows = np.minimum(np.searchsorted(series.time, time), len(series.time) - 1)
    share: Floats = np.clip(np.nan_to_num(magnitude[rows] / largest), 0.0, 1.0)
    return share
