"""What the torque of a delta robot needs of its motion, written once: with numbers for numba, with symbols for C."""

from typing import Any

import numpy as np

from trajectories.closed_chain import (
    Vector,
    Vectors,
    arms,
    cross,
    dot,
    minus,
    motion,
    platform,
    plus,
    rods_from,
    scaled,
)

_STILL = 1e-3
"""Angular velocity of a ball around which its dry friction sets in, without a step [rad/s]."""


def delta_motion(
    lengths: Any, cosines: Any, sines: Any, q: Any, v: Any, a: Any
) -> tuple[Vector, Vectors, Vectors, Vector, Vectors]:
    """Velocity of the platform; its J and the elbows' derivative, per joint; lifts of the platform and of the elbows.

    J is the platform's velocity per unit of a joint's, Eq. (16). A lift is an acceleration minus that of gravity
    [m/s^2]. All is NaN where the mechanism does not close.

    lengths: L1, L2, R - r [m] and g [m/s^2]; cosines, sines: (3,) of the directions of the limbs; q, v, a: (3,) of
    the joints.
    """
    elbows, tangents, bends = arms(lengths[0], lengths[2], cosines, sines, q)
    rods = rods_from(elbows, platform(elbows, lengths[1])[0])
    velocity, acceleration, J = motion(rods, tangents, bends, v, a)
    lifts = (
        _lifted(plus(scaled(a[0], tangents[0]), scaled(v[0] * v[0], bends[0])), lengths[3]),
        _lifted(plus(scaled(a[1], tangents[1]), scaled(v[1] * v[1], bends[1])), lengths[3]),
        _lifted(plus(scaled(a[2], tangents[2]), scaled(v[2] * v[2], bends[2])), lengths[3]),
    )
    return velocity, J, tangents, _lifted(acceleration, lengths[3]), lifts


def load_torques(
    own: Any, mass: Any, rod_mass: Any, J: Vectors, tangents: Vectors, lift: Vector, lifts: Vectors
) -> Vector:
    """Torques (3,) [N m] that move and hold a `mass` at the platform and a uniform rod in each limb, added to `own`.

    A rod whose ends accelerate with a_1 (elbow) and a_2 (platform) resists with m (2 a_1 + a_2) / 6 at the elbow and
    m (a_1 + 2 a_2) / 6 at the platform; the same for its weight.

    mass: at the platform, with that of one rod: 2 m / 6 of each of the three. All others: of `delta_motion`.
    """
    sixth = rod_mass / 6
    force = plus(scaled(mass, lift), scaled(sixth, lifts[0]))
    force = plus(plus(force, scaled(sixth, lifts[1])), scaled(sixth, lifts[2]))
    return (
        _at_elbow(own[0], sixth, tangents[0], lifts[0], lift) + dot(J[0], force),
        _at_elbow(own[1], sixth, tangents[1], lifts[1], lift) + dot(J[1], force),
        _at_elbow(own[2], sixth, tangents[2], lifts[2], lift) + dot(J[2], force),
    )


def _at_elbow(own: Any, sixth: Any, tangent: Vector, elbow: Vector, lift: Vector) -> Any:
    x, y = sixth * tangent[0] * (2 * elbow[0] + lift[0]), sixth * tangent[1] * (2 * elbow[1] + lift[1])
    return own + x + y + sixth * tangent[2] * (2 * elbow[2] + lift[2])


def _lifted(acceleration: Vector, g: Any) -> Vector:
    return acceleration[0], acceleration[1], acceleration[2] + g


def ball_torques(lengths: Any, cosines: Any, sines: Any, q: Any, v: Any) -> tuple[Vector, Vector]:
    """Torques (3,) of unit dry [N m] and unit viscous [N m s/rad] friction in the balls at both ends of the rods.

    A ball turns with the angular velocity w of its rod relative to the arm, or to the platform, which only
    translates. The power |w| or w^2 that it takes is that of the torques: tau_j is the sum of w/|w| . dw/dv_j, or of
    w . dw/dv_j. A rod does not spin about its axis: it turns with s x s' / L2^2.

    All arguments: of `delta_motion`.
    """
    elbows, tangents, bends = arms(lengths[0], lengths[2], cosines, sines, q)
    rods = rods_from(elbows, platform(elbows, lengths[1])[0])
    velocity, _, J = motion(rods, tangents, bends, v, v)
    first = _balls(lengths[1], cosines[0], sines[0], v[0], rods[0], tangents[0], velocity)
    second = _balls(lengths[1], cosines[1], sines[1], v[1], rods[1], tangents[1], velocity)
    third = _balls(lengths[1], cosines[2], sines[2], v[2], rods[2], tangents[2], velocity)
    dry, viscous = plus(plus(first[0], second[0]), third[0]), plus(plus(first[2], second[2]), third[2])
    return (
        (dot(J[0], dry) - first[1], dot(J[1], dry) - second[1], dot(J[2], dry) - third[1]),
        (dot(J[0], viscous) - first[3], dot(J[1], viscous) - second[3], dot(J[2], viscous) - third[3]),
    )


def _balls(
    L2: Any, cosine: Any, sine: Any, rate: Any, rod: Vector, tangent: Vector, velocity: Vector
) -> tuple[Vector, Any, Vector, Any]:
    """Force on the platform, and torque on the arm, of one limb's balls: by dry, then by viscous friction."""
    axis = (sine, -cosine, 0.0)
    along = scaled(1 / (L2 * L2), rod)
    at_platform = cross(along, minus(velocity, scaled(rate, tangent)))
    at_arm = minus(at_platform, scaled(rate, axis))
    dry = scaled(1 / np.sqrt(dot(at_arm, at_arm) + _STILL**2), at_arm)
    force = cross(plus(scaled(1 / np.sqrt(dot(at_platform, at_platform) + _STILL**2), at_platform), dry), along)
    viscous_force = cross(plus(at_platform, at_arm), along)
    return (
        force,
        dot(tangent, force) + dot(axis, dry),
        viscous_force,
        dot(tangent, viscous_force) + dot(axis, at_arm),
    )
