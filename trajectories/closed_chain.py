"""Equations of the delta robot's closed chain, written once: Appendix A, Eqs. (11)-(16) and (23).

With numbers they are compiled by numba, with arrays (n,) they give n instants, with symbols they become C. A vector
is a tuple of three. Arms are moved inwards by r, so that their rods end in the platform's centre.
"""

from typing import Any

import numpy as np

Vector = tuple[Any, Any, Any]
Vectors = tuple[Vector, Vector, Vector]
"""One vector for each limb."""


def arms(L1: float, out: float, cosines: Any, sines: Any, theta: Any) -> tuple[Vectors, Vectors, Vectors]:
    """Elbows [m], and their first and second derivative by the angles theta (3,) [rad]: Pi_i (14) is the first.

    out: R - r [m]; cosines, sines: (3,) of the directions of the limbs.
    """
    first = _arm(L1, out, cosines[0], sines[0], theta[0])
    second = _arm(L1, out, cosines[1], sines[1], theta[1])
    third = _arm(L1, out, cosines[2], sines[2], theta[2])
    return (first[0], second[0], third[0]), (first[1], second[1], third[1]), (first[2], second[2], third[2])


def _arm(L1: float, out: float, cosine: Any, sine: Any, theta: Any) -> Vectors:
    along, up = L1 * np.cos(theta), L1 * np.sin(theta)
    elbow = ((out + along) * cosine, (out + along) * sine, up)
    return elbow, (-up * cosine, -up * sine, along), (-along * cosine, -along * sine, -up)


def platform(elbows: Vectors, L2: float) -> tuple[Vector, Any]:
    """Position [m] of the platform, and the square of the radius of the circle through the elbows [m^2].

    The platform is at an intersection of three spheres of radius L2 around the elbows. The two intersections lie on
    either side of the plane of the elbows; the platform is at the lower one, NaN where there is none. (A7)-(A8)
    divide by the z component of the plane's normal; here stands the circumcentre instead, which is symmetric.
    """
    a, b = minus(elbows[1], elbows[0]), minus(elbows[2], elbows[0])
    c, normal = minus(a, b), cross(a, b)
    aa, bb, nn = dot(a, a), dot(b, b), dot(normal, normal)
    radius_squared = aa * bb * dot(c, c) / (4 * nn)
    to_centre = scaled(1 / (2 * nn), cross(minus(scaled(aa, b), scaled(bb, a)), normal))
    below = np.copysign(np.sqrt((L2 * L2 - radius_squared) / nn), normal[2])
    return minus(plus(elbows[0], to_centre), scaled(below, normal)), radius_squared


def rods_from(elbows: Vectors, P: Vector) -> Vectors:
    """The rods s_i (11) from elbows to the platform's position `P` [m]."""
    return minus(P, elbows[0]), minus(P, elbows[1]), minus(P, elbows[2])


def volume(rods: Vectors) -> Any:
    """Determinant of the rods [m^3]: 0 where they are coplanar."""
    return dot(rods[0], cross(rods[1], rods[2]))


def motion(
    rods: Vectors, tangents: Vectors, bends: Vectors, rates: Any, accelerations: Any
) -> tuple[Vector, Vector, Vectors]:
    """Velocity [m/s] and acceleration [m/s^2] of the platform, and its velocity per unit of each joint's, J (16).

    tangents, bends: derivatives of the elbows. rates, accelerations: (3,) of the joints [rad/s, rad/s^2]. (15), (23).
    """
    by_volume, leverage = 1 / volume(rods), dots(rods, tangents)
    rows = (
        scaled(by_volume, cross(rods[1], rods[2])),
        scaled(by_volume, cross(rods[2], rods[0])),
        scaled(by_volume, cross(rods[0], rods[1])),
    )
    J = (scaled(leverage[0], rows[0]), scaled(leverage[1], rows[1]), scaled(leverage[2], rows[2]))
    velocity = combined(rates, J)
    bent = curvatures(rods, tangents, bends, rates, velocity)
    acceleration = plus(combined(accelerations, J), scaled(bent[0], rows[0]))
    return velocity, plus(plus(acceleration, scaled(bent[1], rows[1])), scaled(bent[2], rows[2])), J


def curvatures(rods: Vectors, tangents: Vectors, bends: Vectors, rates: Any, velocity: Vector) -> Vector:
    """What s_i . P_ddot has beside s_i . Pi_i theta_ddot_i [m^2/s^2], by the platform's `velocity`: Eq. (23)."""
    return (
        _curvature(rods[0], tangents[0], bends[0], rates[0], velocity),
        _curvature(rods[1], tangents[1], bends[1], rates[1], velocity),
        _curvature(rods[2], tangents[2], bends[2], rates[2], velocity),
    )


def _curvature(rod: Vector, tangent: Vector, bend: Vector, rate: Any, velocity: Vector) -> Any:
    change = minus(velocity, scaled(rate, tangent))
    x = (change[0] * tangent[0] + rod[0] * bend[0] * rate) * rate - change[0] * velocity[0]
    y = (change[1] * tangent[1] + rod[1] * bend[1] * rate) * rate - change[1] * velocity[1]
    z = (change[2] * tangent[2] + rod[2] * bend[2] * rate) * rate - change[2] * velocity[2]
    return x + y + z


def plus(a: Vector, b: Vector) -> Vector:
    """Sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def minus(a: Vector, b: Vector) -> Vector:
    """Difference of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(x: Any, a: Vector) -> Vector:
    """The vector `a` times the number `x`."""
    return x * a[0], x * a[1], x * a[2]


def dot(a: Vector, b: Vector) -> Any:
    """Scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def dots(a: Vectors, b: Vectors) -> Vector:
    """Scalar products of each limb's vectors: s_i . Pi_i [m^2] of rods and tangents."""
    return dot(a[0], b[0]), dot(a[1], b[1]), dot(a[2], b[2])


def cross(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def combined(factors: Any, vectors: Vectors) -> Vector:
    """Sum of three vectors, each times its factor."""
    return plus(plus(scaled(factors[0], vectors[0]), scaled(factors[1], vectors[1])), scaled(factors[2], vectors[2]))
