"""Where the parts of a delta robot are at the instants of a recording."""

from dataclasses import dataclass

import numpy as np

from ident.workbench.views import RecordingView, Series
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import kinematics

_RATE = 20.0
"""Postures per second [Hz]."""
_CALM, _LOUD = (138, 148, 156), (213, 94, 0)
"""Colours of a limb with the least residual and the largest."""


@dataclass(frozen=True, eq=False)
class Posture:
    """n instants of three limbs."""

    geometry: Geometry
    step: float
    """[s]"""
    time: Floats
    platform: Floats
    """(n, 3) [m]."""
    shoulders: Floats
    """(3 limbs, 3) [m]."""
    elbows: Floats
    """(n, 3 limbs, 3) [m]."""
    ends: Floats
    """(n, 3 limbs, 3) where the forearms meet the platform [m]."""
    share: Floats
    """(n, 3 limbs) size of the residual, 0 to 1 of the largest that is usual."""

    def colour(self, i: int, limb: int) -> str:
        """Of a limb at the instant `i`."""
        share = float(self.share[i, limb])
        return "#" + "".join(f"{round(a + share * (b - a)):02x}" for a, b in zip(_CALM, _LOUD, strict=True))

    @staticmethod
    def turned(start: Floats, end: Floats) -> list[list[float]]:
        """Rotation that lays a cylinder, which stands along y, from `start` to `end` (3,)."""
        y = (end - start) / np.linalg.norm(end - start)
        x = np.cross(y, [0.0, 0.0, 1.0])
        x = x / np.linalg.norm(x) if np.linalg.norm(x) > 1e-9 else np.array([1.0, 0.0, 0.0])
        turned: list[list[float]] = np.stack([x, y, np.cross(x, y)], axis=1).tolist()
        return turned


def postures(view: RecordingView, series: Series | None) -> Posture:
    """Of the delta robot in `view`; `series`: what a model leaves of it."""
    geometry = view.geometry
    assert geometry is not None
    position = view.signals["position"][1].astype(float)
    known = np.flatnonzero(np.isfinite(position).all(axis=1))
    wanted = np.arange(view.time[known[0]], view.time[known[-1]], 1 / _RATE)
    rows = known[np.minimum(np.searchsorted(view.time[known], wanted), len(known) - 1)]
    theta = position[rows]
    platform = kinematics.forward(geometry, theta)
    phi = np.array(geometry.phi)
    out = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)
    reach = (geometry.R + geometry.L1 * np.cos(theta))[:, :, None] * out
    reach[:, :, 2] = geometry.L1 * np.sin(theta)
    return Posture(
        geometry=geometry,
        step=1 / _RATE,
        time=view.time[rows],
        platform=platform,
        shoulders=geometry.R * out,
        elbows=reach,
        ends=platform[:, None, :] + geometry.r * out,
        share=_share(series, view.time[rows]),
    )


def _share(series: Series | None, time: Floats) -> Floats:
    if series is None:
        return np.zeros((len(time), 3))
    size = np.abs(series.residual)
    largest = np.nanquantile(size, 0.98)
    at = np.minimum(np.searchsorted(series.time, time), len(series.time) - 1)
    share: Floats = np.clip(np.nan_to_num(size[at] / largest), 0.0, 1.0)
    return share
