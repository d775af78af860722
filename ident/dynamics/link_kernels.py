"""Compiled dynamics of a tree of links, by twists and wrenches about the origin of its base.

A twist is an angular velocity with the velocity of the origin, a wrench a moment about the origin with a force.
Equations: R. Featherstone, Rigid Body Dynamics Algorithms (2008), Tables 5.1 and 6.2.
"""

import math
from typing import Any

from recordings.recording import Floats
from trajectories.closed_chain import Vector, combined, cross, dot, minus, plus, scaled

Screw = tuple[Vector, Vector]
"""Turn and move of a twist, or moment and force of a wrench."""
ROW = 22
"""Numbers of a link."""


def link_dynamics(constants: Floats, q: Floats, v: Floats, a: Floats, torque: Floats, inertia: Floats) -> None:
    """Torque (dof,) and inertia (dof, dof) of a tree of links and of its motors at one instant.

    constants: inertia (dof, dof) of the motors, constant torque (dof,), gravity (3,) and `RigidChain.kernel_rows`.
    """
    dof, zero = len(q), (0.0, 0.0, 0.0)
    g = dof * (dof + 1)
    links = constants[g + 3 :].reshape(dof, ROW)
    base = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), zero
    gravity = zero, (-constants[g], -constants[g + 1], -constants[g + 2])  # the base rises instead
    states = [(base, (zero, zero), (zero, zero), gravity)]
    wrenches, bodies = [(zero, zero)], [(0.0, zero, (zero, zero, zero))]
    for i in range(dof):
        j, (pose, _, rate, acceleration) = int(links[i, 1]), states[int(links[i, 0])]
        pose, joint = _moved(links, i, pose, q[j])
        rate, body = _added(rate, v[j], joint), _placed(links, i, pose)
        acceleration = _added(_added(acceleration, a[j], joint), v[j], _carried(rate, joint))
        moment, force = _momentum(body, rate)
        turning = plus(cross(rate[0], moment), cross(rate[1], force)), cross(rate[0], force)
        states.append((pose, joint, rate, acceleration))
        bodies.append(body)
        wrenches.append(_added(_momentum(body, acceleration), 1.0, turning))
    for i in range(dof):
        torque[i] = constants[dof * dof + i]
        for m in range(dof):
            inertia[i, m] = constants[dof * i + m]
            torque[i] += inertia[i, m] * a[m]
    for i in range(dof, 0, -1):
        parent, j = int(links[i - 1, 0]), int(links[i - 1, 1])
        torque[j] += _power(states[i][1], wrenches[i])
        momentum = _momentum(bodies[i], states[i][1])
        inertia[j, j] += _power(states[i][1], momentum)
        wrenches[parent] = _added(wrenches[parent], 1.0, wrenches[i])
        bodies[parent] = _joined(bodies[parent], bodies[i])
        while parent > 0:
            m, shared = int(links[parent - 1, 1]), _power(states[parent][1], momentum)
            inertia[j, m] += shared
            inertia[m, j] += shared
            parent = int(links[parent - 1, 0])


def _moved(links: Floats, i: int, pose: Any, q: float) -> tuple[Any, Screw]:
    """Pose of link `i` by that of its parent, and the twist by a unit of its joint; a pose is rows and a place."""
    rows, own, zero = pose[0], _vector(links, i, 3), (0.0, 0.0, 0.0)
    axis, place = _turned(rows, own), plus(pose[1], _turned(rows, _vector(links, i, 6)))
    if links[i, 2] == 0.0:
        return (rows, plus(place, scaled(q, axis))), (zero, axis)
    s, c = math.sin(q), math.cos(q)
    rows = (_row_turned(rows[0], own, s, c), _row_turned(rows[1], own, s, c), _row_turned(rows[2], own, s, c))
    return (rows, place), (axis, cross(place, axis))


def _row_turned(row: Vector, axis: Vector, s: float, c: float) -> Vector:
    """Row of a rotation matrix after a rotation about an `axis` of its link: Rodrigues, with sine and cosine."""
    across = cross(row, axis)
    return plus(plus(row, scaled(s, across)), scaled(1 - c, cross(across, axis)))


def _placed(links: Floats, i: int, pose: Any) -> tuple[float, Vector, Any]:
    """Mass, first moments and second moments of link `i` about the origin."""
    rows, place = pose
    mass, own = links[i, 9], _turned(rows, _vector(links, i, 10))
    first, x, y, z = (
        plus(own, scaled(mass, place)),
        _vector(links, i, 13),
        _vector(links, i, 16),
        _vector(links, i, 19),
    )
    second = (
        _second(rows, combined(rows[0], (x, y, z)), own[0], place[0], place, first),
        _second(rows, combined(rows[1], (x, y, z)), own[1], place[1], place, first),
        _second(rows, combined(rows[2], (x, y, z)), own[2], place[2], place, first),
    )
    return mass, first, second


def _second(rows: Any, own: Vector, moment: float, at: float, place: Vector, first: Vector) -> Vector:
    return plus(plus(_turned(rows, own), scaled(moment, place)), scaled(at, first))


def _momentum(body: Any, twist: Screw) -> Screw:
    """Moment and force of a body's momentum; of its second moments, those about an axis are the others' sum."""
    mass, first, second = body
    trace = second[0][0] + second[1][1] + second[2][2]
    moment = plus(minus(scaled(trace, twist[0]), _turned(second, twist[0])), cross(first, twist[1]))
    return moment, plus(scaled(mass, twist[1]), cross(twist[0], first))


def _joined(a: Any, b: Any) -> tuple[float, Vector, Any]:
    second = (plus(a[2][0], b[2][0]), plus(a[2][1], b[2][1]), plus(a[2][2], b[2][2]))
    return a[0] + b[0], plus(a[1], b[1]), second


def _carried(rate: Screw, joint: Screw) -> Screw:
    """Change of a joint's twist by the motion of its link."""
    return cross(rate[0], joint[0]), plus(cross(rate[0], joint[1]), cross(rate[1], joint[0]))


def _added(a: Screw, x: float, b: Screw) -> Screw:
    return plus(a[0], scaled(x, b[0])), plus(a[1], scaled(x, b[1]))


def _power(twist: Screw, wrench: Screw) -> float:
    return dot(twist[0], wrench[0]) + dot(twist[1], wrench[1])


def _turned(rows: Any, x: Vector) -> Vector:
    return dot(rows[0], x), dot(rows[1], x), dot(rows[2], x)


def _vector(links: Floats, i: int, column: int) -> Vector:
    return links[i, column], links[i, column + 1], links[i, column + 2]
