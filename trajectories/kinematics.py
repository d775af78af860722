"""Kinematics of the delta robot: Appendices A and B, the Jacobian (16) and its derivative (24).

All functions take and return n instants, time first: joint angles theta (n, 3) [rad], platform positions P (n, 3)
[m]. A row with NaN gives NaN; only `inverse`, which is for commanded paths, raises an error.

Notation of the paper: u_i is the direction of limb i in the base plane, s_i (11) the forearm from elbow to
platform, Pi_i (14) the elbow's velocity per unit of joint speed.
"""

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Geometry

GRAVITY: Floats = np.array([0.0, 0.0, -9.81])
"""[m/s^2]"""

_ignore_invalid = np.errstate(invalid="ignore", divide="ignore")
"""Suppresses warnings: unknown and singular rows give NaN or infinity, which the caller masks."""


class Unreachable(BadInput):
    """The mechanism does not close at one instant.

    `row` is the index of that instant. `limb` is 1, 2 or 3, or None where no single limb is the cause. `excess` [m]
    is the amount by which a length is too short or too long.
    """

    def __init__(self, what: str, *, row: int, limb: int | None, excess: float, remedy: str) -> None:
        super().__init__(f"row {row}: {what}; {remedy}")
        self.what, self.row, self.limb, self.excess, self.remedy = what, row, limb, excess, remedy

    def at(self, instant: str) -> "Unreachable":
        """Copy the error with `instant` (e.g. "t = 1.250 s") in place of the row number."""
        error = Unreachable(self.what, row=self.row, limb=self.limb, excess=self.excess, remedy=self.remedy)
        error.args = (f"{instant}: {self.what}; {self.remedy}",)
        return error


@_ignore_invalid
def forward(geometry: Geometry, theta: Floats) -> Floats:
    """Platform position (n, 3) [m] at the joint angles theta (n, 3) [rad]: Appendix A in closed form.

    The platform is at an intersection of three spheres of radius L2, whose centres are the elbows moved inwards by r.
    The two intersections lie on either side of the plane of the centres; the platform is at the lower one. (A7)-(A8)
    divide by the z component of the plane's normal; this code uses the circumcentre instead, which is symmetric.

    Raises:
        Unreachable: the spheres do not intersect.
    """
    first, second, third = np.moveaxis(_sphere_centres(geometry, theta), 1, 0)
    a, b = second - first, third - first
    normal = _cross(a, b)
    aa, bb, nn = _dot(a, a), _dot(b, b), _dot(normal, normal)
    radius_squared = aa * bb * _dot(a - b, a - b) / (4 * nn)
    _check_closed(geometry, radius_squared)
    to_centre = _cross(aa[:, None] * b - bb[:, None] * a, normal) / (2 * nn)[:, None]
    below = np.copysign(np.sqrt((geometry.L2**2 - radius_squared) / nn), normal[:, 2])
    platform: Floats = first + to_centre - below[:, None] * normal
    return platform


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
def jacobian(geometry: Geometry, theta: Floats, P: Floats) -> Floats:
    """Jacobian J (n, 3, 3) [m/rad], P_dot = J theta_dot, Eq. (16). Infinite or NaN where the rods are coplanar."""
    inverse_rods = _inverse(_rods(geometry, theta, P))
    return inverse_rods * _arm_leverage(geometry, theta, P)[:, None, :]


@_ignore_invalid
def jacobian_derivative(geometry: Geometry, theta: Floats, P: Floats, theta_dot: Floats, J: Floats) -> Floats:
    """Time derivative (n, 3, 3) [m/(rad s)] of J = `jacobian(geometry, theta, P)` at theta_dot (n, 3) [rad/s].

    Eq. (24); the term on the diagonal is the time derivative of s_i . Pi_i.
    """
    P_dot = np.einsum("nij,nj->ni", J, theta_dot)
    bracket = -np.matmul(_rod_rates(geometry, theta, theta_dot, P_dot), J)
    limb = np.arange(3)
    bracket[:, limb, limb] += _arm_leverage_rate(geometry, theta, P, theta_dot, P_dot)
    derivative: Floats = np.matmul(_inverse(_rods(geometry, theta, P)), bracket)
    return derivative


@_ignore_invalid
def joint_motion(
    geometry: Geometry, theta: Floats, P: Floats, P_dot: Floats, P_ddot: Floats
) -> tuple[Floats, Floats]:
    """Joint speed [rad/s] and acceleration [rad/s^2], both (n, 3), from the platform motion: Eqs. (15), (23).

    Not finite where an arm and its rod are aligned.
    """
    rods, leverage = _rods(geometry, theta, P), _arm_leverage(geometry, theta, P)
    theta_dot: Floats = np.einsum("nij,nj->ni", rods, P_dot) / leverage
    curvature = np.einsum("nij,nj->ni", _rod_rates(geometry, theta, theta_dot, P_dot), P_dot)
    curvature -= _arm_leverage_rate(geometry, theta, P, theta_dot, P_dot) * theta_dot
    theta_ddot: Floats = (np.einsum("nij,nj->ni", rods, P_ddot) + curvature) / leverage
    return theta_dot, theta_ddot


@_ignore_invalid
def platform_motion(
    geometry: Geometry, theta: Floats, theta_dot: Floats, theta_ddot: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """P, P_dot, P_ddot (n, 3) [m, m/s, m/s^2] and J (n, 3, 3) from the joint motion: Eqs. (15), (16), (23).

    The inverse of `joint_motion`; J as in `jacobian`. Not finite where the rods are coplanar.
    """
    P = forward(geometry, theta)
    inverse_rods, leverage = _inverse(_rods(geometry, theta, P)), _arm_leverage(geometry, theta, P)
    J: Floats = inverse_rods * leverage[:, None, :]
    P_dot: Floats = np.matmul(J, theta_dot[:, :, None])[:, :, 0]
    forced = leverage * theta_ddot + _arm_leverage_rate(geometry, theta, P, theta_dot, P_dot) * theta_dot
    forced -= np.einsum("nij,nj->ni", _rod_rates(geometry, theta, theta_dot, P_dot), P_dot)
    P_ddot: Floats = np.matmul(inverse_rods, forced[:, :, None])[:, :, 0]
    return P, P_dot, P_ddot, J


@_ignore_invalid
def singularity_margin(geometry: Geometry, theta: Floats, P: Floats) -> Floats:
    """Distance from the nearest singularity (n,), dimensionless: 0 at a singularity, at most 1.

    The smallest of four numbers: |s_i . Pi_i| / (L1 L2), the cosine between rod i and the velocity of its
    elbow (0: arm and rod aligned, the joint cannot move the platform), and |det [s_1 s_2 s_3]| / L2^3, the volume
    spanned by the rod directions (0: coplanar, the joints cannot hold the platform).
    """
    s1, s2, s3 = np.moveaxis(_rods(geometry, theta, P), 1, 0)
    volume = np.abs(_dot(s1, _cross(s2, s3))) / geometry.L2**3
    cosine = np.abs(_arm_leverage(geometry, theta, P)).min(axis=1) / (geometry.L1 * geometry.L2)
    margin: Floats = np.minimum(volume, cosine)
    return margin


def _directions(geometry: Geometry) -> Floats:
    """Limb directions u_i as rows (3, 3)."""
    phi = np.array(geometry.phi)
    return np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=1)


def _sphere_centres(geometry: Geometry, theta: Floats) -> Floats:
    """Elbows moved inwards by r (n, 3 limbs, 3) [m], so that the spheres around them intersect in P."""
    centres: Floats = (geometry.R - geometry.r + geometry.L1 * np.cos(theta))[:, :, None] * _directions(geometry)
    centres[:, :, 2] = geometry.L1 * np.sin(theta)
    return centres


def _rods(geometry: Geometry, theta: Floats, P: Floats) -> Floats:
    """Rod vectors s_i as rows (n, 3 limbs, 3) [m], Eq. (11)."""
    rods: Floats = P[:, None, :] - _sphere_centres(geometry, theta)
    return rods


def _rod_rates(geometry: Geometry, theta: Floats, theta_dot: Floats, P_dot: Floats) -> Floats:
    """Time derivative of s_i as rows (n, 3 limbs, 3), Eq. (14)."""
    rates: Floats = P_dot[:, None, :] + (geometry.L1 * np.sin(theta) * theta_dot)[:, :, None] * _directions(geometry)
    rates[:, :, 2] -= geometry.L1 * np.cos(theta) * theta_dot
    return rates


def _in_limb_frames(geometry: Geometry, P: Floats) -> tuple[Floats, Floats, Floats]:
    """Coordinates x, y, z of the platform joint C_i in the frame of each limb, each (n, 3 limbs) [m]: (A10)."""
    along = _directions(geometry)
    across = np.stack([-along[:, 1], along[:, 0], along[:, 2]], axis=1)
    return P @ along.T + (geometry.r - geometry.R), P @ across.T, P[:, 2:]


def _arm_leverage(geometry: Geometry, theta: Floats, P: Floats) -> Floats:
    """Products s_i . Pi_i (n, 3) [m^2]; after cancellation only x and z of the platform remain."""
    x, _, z = _in_limb_frames(geometry, P)
    leverage: Floats = geometry.L1 * (np.cos(theta) * z - np.sin(theta) * x)
    return leverage


def _arm_leverage_rate(geometry: Geometry, theta: Floats, P: Floats, theta_dot: Floats, P_dot: Floats) -> Floats:
    """Time derivative of s_i . Pi_i (n, 3) [m^2/s]."""
    x, _, z = _in_limb_frames(geometry, P)
    x_dot, z_dot = P_dot @ _directions(geometry).T, P_dot[:, 2:]
    sin, cos = np.sin(theta), np.cos(theta)
    rate: Floats = geometry.L1 * (cos * z_dot - sin * x_dot - theta_dot * (sin * z + cos * x))
    return rate


def _inverse(rows: Floats) -> Floats:
    """Inverses (n, 3, 3) of matrices given by their rows; the columns are cross products of the rows."""
    a, b, c = np.moveaxis(rows, 1, 0)
    columns = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=2)
    columns /= _dot(a, columns[:, :, 0])[:, None, None]
    return columns


def _cross(a: Floats, b: Floats) -> Floats:
    """Cross products (n, 3); numpy.cross takes three times as long."""
    (ax, ay, az), (bx, by, bz) = a.T, b.T
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=1)


def _dot(a: Floats, b: Floats) -> Floats:
    products: Floats = np.einsum("ni,ni->n", a, b)
    return products


def _check_closed(geometry: Geometry, radius_squared: Floats) -> None:
    outside = radius_squared > geometry.L2**2
    if outside.any():
        row = int(np.argmax(outside))
        excess = float(np.sqrt(radius_squared[row])) - geometry.L2
        raise Unreachable(
            f"the joint angles tear the mechanism apart: its forearms are {1e3 * excess:.3f} mm shorter than the "
            "radius of the circle through the elbows",
            row=row,
            limb=None,
            excess=excess,
            remedy="check the angles, their zero offsets and the geometry",
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
            f"limb {limb + 1} cannot reach {_point(P[row])}, its forearm is {1e3 * miss:.3f} mm too {error}",
            row=row,
            limb=limb + 1,
            excess=miss,
            remedy="move the path towards the middle of the workspace",
        )


def _check_not_flipped(geometry: Geometry, theta: Floats, P: Floats) -> None:
    first, second, third = np.moveaxis(_sphere_centres(geometry, theta), 1, 0)
    normal = _cross(second - first, third - first)
    height = _dot(P - first, normal) * np.sign(normal[:, 2])
    flipped = height > 0
    if flipped.any():
        row = int(np.argmax(flipped))
        excess = float(height[row] / np.linalg.norm(normal[row]))
        raise Unreachable(
            f"at {_point(P[row])} the platform stands {1e3 * excess:.3f} mm above the plane of its elbows",
            row=row,
            limb=None,
            excess=excess,
            remedy="lower the path (z points up, the platform hangs below the base)",
        )


def _point(P: Floats) -> str:
    return "(" + ", ".join(f"{value:.4f}" for value in P) + ") m"
