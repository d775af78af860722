"""Poses of a delta robot over time, its limbs coloured by their torque residual."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ident.basics.statistics import TINY
from ident.residuals.time_span import TorqueSeries
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

STEP = 0.05
"""Time between two poses [s]."""
_NOISE_FLOORS = 3.0
"""Noise floors up to which noise explains a residual, and, doubled, the least that has the colour of a large one."""
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
    tangents: Floats
    """(3 limbs, 3) unit vectors along the axes of the shoulders."""
    residual: Floats
    """(n, 3 limbs); NaN where it is not scored."""
    small: Floats
    """(3 limbs) largest residual that noise explains; the colour of the limb does not change below."""
    large: float
    """Residual above which the colour does not change any more."""

    def colour(self, i: int, limb: int) -> str:
        """Return the colour of `limb` (from 0) at the instant `i`."""
        residual, small = np.nan_to_num(abs(self.residual[i, limb])), self.small[limb]
        share = float(np.clip((residual - small) / max(self.large - small, TINY), 0.0, 1.0))
        return "#" + "".join(
            f"{round(a + share * (b - a)):02x}"
            for a, b in zip(_SMALL_RESIDUAL_COLOUR, _LARGE_RESIDUAL_COLOUR, strict=True)
        )

    @staticmethod
    def cylinder_rotation(start: Floats, end: Floats) -> list[list[float]]:
        """Return the rotation matrix that turns a cylinder along y into the direction from `start` to `end` (3,)."""
        rotation, _ = Rotation.align_vectors(end - start, [0.0, 1.0, 0.0])
        return rotation.as_matrix().tolist()


def pose_sequence(
    geometry: Geometry,
    time: Floats,
    position: NDArray[np.floating],
    series: TorqueSeries | None,
    noise_rms: Sequence[float | None] = (None, None, None),
) -> PoseSequence:
    """Compute the poses of a delta robot with joints at `position` (n, 3) over `time` (n,) [s].

    `series` gives the residuals that colour the limbs, compared with the noise floors `noise_rms` if they are known.
    """
    valid_rows = np.flatnonzero(np.isfinite(position).all(axis=1))
    sample_times = np.arange(time[valid_rows[0]], time[valid_rows[-1]], STEP)
    rows = valid_rows[np.minimum(np.searchsorted(time[valid_rows], sample_times), len(valid_rows) - 1)]
    theta = position[rows].astype(float)
    platform = kinematics.forward(geometry, theta)
    phi = np.array(geometry.phi)
    directions = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)
    tangents = np.stack([-np.sin(phi), np.cos(phi), np.zeros(3)], axis=1)
    elbows = (geometry.R + geometry.L1 * np.cos(theta))[:, :, None] * directions
    elbows[:, :, 2] = geometry.L1 * np.sin(theta)
    small = _NOISE_FLOORS * np.array([noise or 0.0 for noise in noise_rms])
    residual = _residual_at(series, time[rows])
    large = 0.0 if series is None else float(np.nanquantile(np.abs(series.residual), 0.98))
    return PoseSequence(
        time=time[rows],
        platform=platform,
        shoulders=geometry.R * directions,
        elbows=elbows,
        platform_joints=platform[:, None, :] + geometry.r * directions,
        tangents=tangents,
        residual=residual,
        small=small,
        large=max(large, 2 * small.max()),
    )


def _residual_at(series: TorqueSeries | None, time: Floats) -> Floats:
    """Return the residuals (n, 3) at the rows nearest to `time` (n,)."""
    if series is None:
        return np.full((len(time), 3), np.nan)
    after = np.clip(np.searchsorted(series.time, time), 1, len(series.time) - 1)
    nearest = after - (time - series.time[after - 1] < series.time[after] - time)
    return series.residual[nearest]
