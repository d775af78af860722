"""What the torque of a delta robot needs of its motion, written once: with numbers for numba, with symbols for C."""

from typing import Any

from trajectories.closed_chain import Vector, Vectors, arms, dot, dots, motion, platform, plus, rods_from, scaled


def delta_motion(
    lengths: Any, cosines: Any, sines: Any, q: Any, v: Any, a: Any
) -> tuple[Vector, Vector, Vectors, Vectors, Vector, Vector]:
    """Velocity and lift of the platform, its velocity J and the elbows' per unit of each joint's, and two torques.

    The lift is the acceleration minus that of gravity [m/s^2]. The torques (3,) are those that move and hold 1 kg at
    the platform, Eqs. (16), (23), and one uniform rod of 1 kg in each limb [N m]. All is NaN where the mechanism does
    not close.

    A rod whose ends accelerate with a_1 (elbow) and a_2 (platform) resists with m (2 a_1 + a_2) / 6 at the elbow and
    m (a_1 + 2 a_2) / 6 at the platform; the same for its weight.

    lengths: L1, L2, R - r [m] and g [m/s^2]; cosines, sines: (3,) of the directions of the limbs; q, v, a: (3,) of
    the joints.
    """
    elbows, tangents, bends = arms(lengths[0], lengths[2], cosines, sines, q)
    rods = rods_from(elbows, platform(elbows, lengths[1])[0])
    velocity, acceleration, J = motion(rods, tangents, bends, v, a)
    lift = _lifted(acceleration, lengths[3])
    first = _lifted(plus(scaled(a[0], tangents[0]), scaled(v[0] * v[0], bends[0])), lengths[3])
    second = _lifted(plus(scaled(a[1], tangents[1]), scaled(v[1] * v[1], bends[1])), lengths[3])
    third = _lifted(plus(scaled(a[2], tangents[2]), scaled(v[2] * v[2], bends[2])), lengths[3])
    force = plus(plus(plus(lift, scaled(1 / 6, first)), scaled(1 / 6, second)), scaled(1 / 6, third))
    of_rods = (
        dot(scaled(1 / 6, tangents[0]), plus(scaled(2, first), lift)) + dot(J[0], force),
        dot(scaled(1 / 6, tangents[1]), plus(scaled(2, second), lift)) + dot(J[1], force),
        dot(scaled(1 / 6, tangents[2]), plus(scaled(2, third), lift)) + dot(J[2], force),
    )
    return velocity, lift, J, tangents, dots((lift, lift, lift), J), of_rods


def _lifted(acceleration: Vector, g: Any) -> Vector:
    return acceleration[0], acceleration[1], acceleration[2] + g
