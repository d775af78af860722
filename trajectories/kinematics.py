"""Kinematics of the delta robot: Appendices A and B, and the Jacobian (16).

All functions take and return n instants, time first: joint angles theta (n, 3) [rad], platform positions P (n, 3)
[m]. A row with NaN gives NaN; only `inverse`, which is for commanded paths, raises an error.
"""

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Geometry
from trajectories import closed_chain
from trajectories.closed_chain import Vector, Vectors

GRAVITY: Floats = np.array([0.0, 0.0, -9.81])
"""[m/s^2]"""

_ignore_invalid = np.errstate(invalid="ignore", divide="ignore")
"""Suppresses warnings: unknown and singular rows give NaN or infinity, which the caller masks."""


class Unreachable(BadInput):
    """The mechanism does not close at one instant, the one with the index `row`."""

    def __init__(self, what: str, row: int, instant: str | None = None) -> None:
        super().__init__(f"{instant or f'row {row}'}: {what}")
        self.what, self.row = what, row

    def at(self, instant: str) -> "Unreachable":
        """Copy the error with `instant` (e.g. "t = 1.250 s") in place of the row number."""
        return Unreachable(self.what, self.row, instant)


@_ignore_invalid
def forward(geometry: Geometry, theta: Floats) -> Floats:
    """Platform position (n, 3) [m] at the joint angles theta (n, 3) [rad]: Appendix A in closed form.

    Raises:
        Unreachable: the mechanism does not close.
    """
    return _stacked(_forward(geometry, _arms(geometry, theta)[0]))


def inverse(geometry: Geometry, P: Floats) -> Floats:
    """Joint angles (n, 3) [rad], elbows out, at the platform positions P (n, 3) [m]: Appendix B in closed form.

    Eliminating theta_i2 and theta_i3 from (A10) leaves x cos(theta) + z sin(theta) = k in the plane of the arm,
    whose two solutions lie on either side of the direction (x, z); elbows out is the upper one.

    Raises:
        BadInput: P holds NaN or infinity.
        Unreachable: a limb cannot reach the position; the error names the first such row and limb, and the excess. Or
            the platform is above the plane of its elbows, where `forward` gives another solution.
    """
    P = np.asarray(P, dtype=np.float64)
    unknown = ~np.isfinite(P).all(axis=1)
    if unknown.any():
        row = int(np.argmax(unknown))
        raise BadInput(f"row {row}: a finite platform position expected, {P[row].tolist()} found; fill the gap first")
    x, y, z = _in_limb_frames(geometry, P)
    reach = np.hypot(x, z)
    _check_reach(geometry, P, reach, y)
    k = (x**2 + y**2 + z**2 + geometry.L1**2 - geometry.L2**2) / (2 * geometry.L1)
    theta: Floats = np.arctan2(z, x) + np.arctan2(np.sqrt(np.maximum(reach**2 - k**2, 0)), k)
    _check_not_flipped(geometry, theta, P)
    return theta


@_ignore_invalid
def joint_motion(
    geometry: Geometry, theta: Floats, P: Floats, P_dot: Floats, P_ddot: Floats
) -> tuple[Floats, Floats]:
    """Joint speed [rad/s] and acceleration [rad/s^2], both (n, 3), from the platform motion: Eqs. (15), (23).

    Not finite where an arm and its rod are aligned.
    """
    elbows, tangents, bends = _arms(geometry, theta)
    rods = closed_chain.rods_from(elbows, tuple(P.T))
    leverage = _stacked(closed_chain.dots(rods, tangents))

    def along_rods(vector: Floats) -> Floats:
        return _stacked(closed_chain.dots(rods, (tuple(vector.T),) * 3))

    theta_dot: Floats = along_rods(P_dot) / leverage
    bent = closed_chain.curvatures(rods, tangents, bends, theta_dot.T, tuple(P_dot.T))
    return theta_dot, (along_rods(P_ddot) - _stacked(bent)) / leverage


@_ignore_invalid
def platform_motion(
    geometry: Geometry, theta: Floats, theta_dot: Floats, theta_ddot: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """P, P_dot, P_ddot (n, 3) [m, m/s, m/s^2] and J (n, 3, 3) [m/rad], P_dot = J theta_dot: Eqs. (15), (16), (23).

    The inverse of `joint_motion`. Not finite where the rods are coplanar.

    Raises:
        Unreachable: the mechanism does not close.
    """
    elbows, tangents, bends = _arms(geometry, theta)
    P = _forward(geometry, elbows)
    rods = closed_chain.rods_from(elbows, P)
    P_dot, P_ddot, J = closed_chain.motion(rods, tangents, bends, theta_dot.T, theta_ddot.T)
    return _stacked(P), _stacked(P_dot), _stacked(P_ddot), np.stack([_stacked(column) for column in J], axis=2)


@_ignore_invalid
def singularity_margin(geometry: Geometry, theta: Floats, P: Floats) -> Floats:
    """Distance from the nearest singularity (n,), dimensionless: 0 at a singularity, at most 1.

    The smallest of four numbers: |s_i . Pi_i| / (L1 L2), the cosine between rod i and the velocity of its
    elbow (0: arm and rod aligned, the joint cannot move the platform), and |det [s_1 s_2 s_3]| / L2^3, the volume
    spanned by the rod directions (0: coplanar, the joints cannot hold the platform).
    """
    elbows, tangents, _ = _arms(geometry, theta)
    rods = closed_chain.rods_from(elbows, tuple(P.T))
    volume = np.abs(closed_chain.volume(rods)) / geometry.L2**3
    cosine = np.abs(_stacked(closed_chain.dots(rods, tangents))).min(axis=1) / (geometry.L1 * geometry.L2)
    return np.minimum(volume, cosine)


def _arms(geometry: Geometry, theta: Floats) -> tuple[Vectors, Vectors, Vectors]:
    phi = np.array(geometry.phi)
    return closed_chain.arms(
        geometry.L1,
        geometry.R - geometry.r,
        np.cos(phi),
        np.sin(phi),
        np.broadcast_to(theta, (*theta.shape[:-1], 3)).T,
    )


def _forward(geometry: Geometry, elbows: Vectors) -> Vector:
    P, radius_squared = closed_chain.platform(elbows, geometry.L2)
    _check_closed(geometry, radius_squared)
    return P


def _stacked(vector: Vector) -> Floats:
    """(n, 3) entries of a vector at n instants."""
    return np.stack(vector, axis=1)


def _in_limb_frames(geometry: Geometry, P: Floats) -> tuple[Floats, Floats, Floats]:
    """Coordinates x, y, z of the platform joint C_i in the frame of each limb, each (n, 3 limbs) [m]: (A10)."""
    cos, sin = np.cos(geometry.phi), np.sin(geometry.phi)
    x, y, z = P[:, :1], P[:, 1:2], P[:, 2:]
    return x * cos + y * sin + (geometry.r - geometry.R), y * cos - x * sin, z


def _check_closed(geometry: Geometry, radius_squared: Floats) -> None:
    outside = radius_squared > geometry.L2**2
    if outside.any():
        row = int(np.argmax(outside))
        excess = float(np.sqrt(radius_squared[row])) - geometry.L2
        raise Unreachable(
            f"the joint angles tear the mechanism apart: its forearms are {1e3 * excess:.3f} mm shorter than the "
            "radius of the circle through the elbows; check the angles, their zero offsets and the geometry",
            row,
        )


def _check_reach(geometry: Geometry, P: Floats, reach: Floats, y: Floats) -> None:
    """Raise Unreachable unless L2 is between the shortest and longest distance from P to the circle of the elbow."""
    too_short = np.hypot(reach - geometry.L1, y) - geometry.L2
    too_long = geometry.L2 - np.hypot(reach + geometry.L1, y)
    excess = np.maximum(too_short, too_long)
    outside = excess > 0
    if outside.any():
        row = int(np.argmax(outside.any(axis=1)))
        limb = int(np.argmax(excess[row]))
        miss = float(excess[row, limb])
        error = "short" if too_short[row, limb] > 0 else "long"
        raise Unreachable(
            f"limb {limb + 1} cannot reach {_point(P[row])}, its forearm is {1e3 * miss:.3f} mm too {error}; "
            "move the path towards the middle of the workspace",
            row,
        )


def _check_not_flipped(geometry: Geometry, theta: Floats, P: Floats) -> None:
    first, second, third = _arms(geometry, theta)[0]
    normal = closed_chain.cross(closed_chain.minus(second, first), closed_chain.minus(third, first))
    height = closed_chain.dot(closed_chain.minus(tuple(P.T), first), normal) * np.sign(normal[2])
    flipped = height > 0
    if flipped.any():
        row = int(np.argmax(flipped))
        excess = float(height[row] / np.linalg.norm(_stacked(normal)[row]))
        raise Unreachable(
            f"at {_point(P[row])} the platform stands {1e3 * excess:.3f} mm above the plane of its elbows; "
            "lower the path (z points up, the platform hangs below the base)",
            row,
        )


def _point(P: Floats) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in P) + ") m"
