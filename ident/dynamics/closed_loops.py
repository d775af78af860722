"""Closed loops of a tree of links: the joints that are not driven follow from the driven ones.

h(q) = 0 says that the two points of each loop are one. J = dh/dq, of driven joints (d) and of those that follow (f):

    q_f: Newton's method along the way of q_d,    q_f' = G q_d',    q_f'' = G q_d'' - J_f^+ J' q',    G = -J_f^+ J_d

By virtual work, the torque of the driven joints is S' tau of that of all joints, with S = [1; G].
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from recordings.errors import BadInput
from recordings.recording import Floats, Ints
from recordings.urdf import Loop
from trajectories.kinematics import Unreachable

_CLOSED = 1e-12
"""Distance of two points that are one [m]; rounding leaves 1e-16."""
_DEPENDENT = 1e-9
"""Share of the largest singular value of J, below which a direction is none: planar loops have equations to spare."""
_STRAY = 0.2
"""Largest correction by Newton's method, of the step that was predicted: larger ones may end on another branch."""
_LEAST_STEP = 1e-3
"""Share of the way that is left, below which no smaller step is tried: the loops do not close further on."""
_ITERATIONS = 50
"""Of Newton's method: two or three are usual, more where it begins far from a closed pose."""
_REGULAR = 0.2
"""Smallest singular value of J_f in random poses, of that in the first one."""


@dataclass(frozen=True, eq=False)
class Pose:
    """One pose of a tree of N joints with l loops."""

    q: Floats
    """(N,) positions, in Pinocchio's order."""
    gap: Floats
    """(3 l,) between the ends of the loops, h [m]."""
    J: Floats
    """(3 l, N)"""

    @property
    def closed(self) -> bool:
        """Whether the ends of each loop meet."""
        return bool(np.abs(self.gap).max() < _CLOSED)


@dataclass(frozen=True, eq=False)
class ClosedLoops:
    """Loops of `model`, a tree of N joints, dof of them driven."""

    model: Any
    """`pinocchio.Model` with a frame at each end of each loop."""
    ends: tuple[tuple[int, int], ...]
    """The two frames of each loop."""
    driven: Ints
    """(dof,) driven joints, in the order of the recording's columns."""
    following: Ints
    """(N - dof,) joints that follow."""
    start: Floats
    """(N,) near which the loops close [rad or m]."""

    def along(self, position: Floats, velocity: Floats, acceleration: Floats) -> tuple[list[Floats], Floats]:
        """Compute position, velocity, acceleration (n, N) of all joints, and S (n, N, dof), of the driven (n, dof).

        Raises:
            Unreachable: the loops do not close on the way to an instant.
        """
        poses, J = _poses(self, np.ascontiguousarray(position).tobytes())
        inverse = np.linalg.pinv(J[:, :, self.following], rcond=_DEPENDENT)
        S = np.zeros((*poses.shape, len(self.driven)))
        S[:, self.driven] = np.eye(len(self.driven))
        S[:, self.following] = -inverse @ J[:, :, self.driven]
        speeds, accelerations = (np.einsum("nij,nj->ni", S, signal) for signal in (velocity, acceleration))
        newton = _Newton(self)
        bends = np.array([newton.bend(*at) for at in zip(poses, speeds, strict=True)]).reshape(len(poses), J.shape[1])
        accelerations[:, self.following] -= np.einsum("nij,nj->ni", inverse, bends)
        return [poses, speeds, accelerations], S

    def wandering(self, targets: Floats) -> Floats:
        """Positions (n, dof) of the driven joints, one after the other on the way to each of `targets` (n, dof).

        All are far from singular poses, where the loops cease to close and the other joints run away.
        """
        newton, at, positions = _Newton(self), first_pose(self), []
        least = _REGULAR * self._regularity(at)
        for target in targets:
            left = target - at.q[self.driven]
            while (near := newton.near(at, at.q[self.driven] + left)) is None or self._regularity(near) < least:
                left = left / 2
            at = near
            positions.append(at.q[self.driven])
        return np.array(positions)

    def _regularity(self, pose: Pose) -> float:
        """Smallest change of the gaps by any motion of the joints that follow; 0 in a singular pose."""
        return float(np.linalg.svd(pose.J[:, self.following], compute_uv=False)[len(self.following) - 1])


def closed_loops(model: Any, loops: Sequence[Loop], driven: Ints, following: Ints, start: Floats) -> ClosedLoops:
    """Return the `loops` of a `pinocchio.Model` made by `rigid_chain`; see `ClosedLoops` for the others.

    Raises:
        BadInput: they do not close near `start`, or leave a joint free.
    """
    import pinocchio

    model = model.copy()

    def frame(link: str, point: Sequence[float]) -> int:
        number = model.getFrameId(f"link:{link}", pinocchio.BODY)
        body = model.frames[number]
        place, name = body.placement * pinocchio.SE3(np.eye(3), np.array(point)), f"end {model.nframes}"
        return int(model.addFrame(pinocchio.Frame(name, body.parentJoint, number, place, pinocchio.OP_FRAME)))

    ends = tuple((frame(loop.a, loop.point_a), frame(loop.b, loop.point_b)) for loop in loops)
    closed = ClosedLoops(model, ends, driven, following, start)
    first_pose(closed)
    return closed


@lru_cache(maxsize=16)
def first_pose(loops: ClosedLoops) -> Pose:
    """The closed pose next to the start: all joints move, halving Newton's step until the ends come nearer.

    Raises:
        BadInput: none is found, or the loops leave a joint free.
    """
    newton, names = _Newton(loops), [name.removeprefix("joint:") for name in loops.model.names][1:]
    pose = newton.pose(loops.start)
    for _ in range(_ITERATIONS):
        if pose.closed:
            break
        step = _solved(pose.J, pose.gap)
        tried = (newton.pose(pose.q - share * step) for share in 0.5 ** np.arange(10))
        pose = next((each for each in tried if np.linalg.norm(each.gap) < np.linalg.norm(pose.gap)), pose)
    if not pose.closed:
        at = ", ".join(f"{name} = {value:.3g}" for name, value in zip(names, pose.q, strict=True))
        raise BadInput(
            f"loops: points that meet near start expected, {np.abs(pose.gap).max():.3g} m between two found at {at}; "
            "check the points, or give start = { JOINT = POSITION } of a pose where they meet"
        )
    _, sizes, directions = np.linalg.svd(pose.J[:, loops.following])
    free = directions[np.count_nonzero(sizes > _DEPENDENT * sizes[0]) :]
    if len(free):
        raise BadInput(
            "loops: joints that follow the driven ones expected, but "
            f"{names[loops.following[np.argmax(np.abs(free[0]))]]} can move while they stand; name it in joints or "
            "fixed, or give start = { JOINT = POSITION } of a pose that is not stretched"
        )
    return pose


class _Newton:
    """Newton's method for closed poses of `loops`. Every call has its own: Pinocchio changes the data."""

    def __init__(self, loops: ClosedLoops) -> None:
        self.loops, self.data = loops, loops.model.createData()

    def toward(self, at: Pose, target: Floats) -> Pose:
        """The closed pose with the driven joints at `target`, from one `at` others, or as near as the loops close."""
        driven, share = self.loops.driven, 1.0
        while (left := target - at.q[driven]).any() and share > _LEAST_STEP:
            if (near := self.near(at, target - (1 - share) * left)) is None:
                share /= 2
            else:
                at, share = near, min(1.0, 2 * share / (1 - share)) if share < 1 else 1.0
        return at

    def near(self, at: Pose, target: Floats) -> Pose | None:
        """The closed pose next to one `at` other positions of the driven joints; None if Newton's method strays."""
        driven, following = self.loops.driven, self.loops.following
        q = at.q.copy()
        q[driven] = target
        q[following] -= _solved(at.J[:, following], at.J[:, driven] @ (target - at.q[driven]))
        predicted = q.copy()
        allowed = _STRAY * np.abs(predicted - at.q).max() + _DEPENDENT
        for _ in range(_ITERATIONS):
            pose = self.pose(q)
            if pose.closed:
                return pose
            q[following] -= _solved(pose.J[:, following], pose.gap)
            if np.abs(q - predicted).max() > allowed:
                break
        return None

    def pose(self, q: Floats) -> Pose:
        """The pose at `q` (N,)."""
        import pinocchio

        model, data, aligned = self.loops.model, self.data, pinocchio.LOCAL_WORLD_ALIGNED
        pinocchio.computeJointJacobians(model, data, q)
        pinocchio.updateFramePlacements(model, data)

        def slopes(end: int) -> Floats:
            return pinocchio.getFrameJacobian(model, data, end, aligned)[:3]

        gaps = [data.oMf[a].translation - data.oMf[b].translation for a, b in self.loops.ends]
        J = [slopes(a) - slopes(b) for a, b in self.loops.ends]
        return Pose(q.copy(), np.concatenate(gaps), np.concatenate(J))

    def bend(self, q: Floats, speeds: Floats) -> Floats:
        """J' q' (3 l,) [m/s^2]: how the ends of the loops part if no joint accelerates."""
        import pinocchio

        model, data, aligned = self.loops.model, self.data, pinocchio.LOCAL_WORLD_ALIGNED
        pinocchio.forwardKinematics(model, data, q, speeds, np.zeros_like(speeds))
        parted = [
            np.subtract(*(pinocchio.getFrameClassicalAcceleration(model, data, end, aligned).linear for end in ends))
            for ends in self.loops.ends
        ]
        return np.concatenate(parted)


@lru_cache(maxsize=4)
def _poses(loops: ClosedLoops, position: bytes) -> tuple[Floats, Floats]:
    """Closed poses (n, N) and J (n, 3 l, N); one position is asked for with many speeds and accelerations."""
    newton, at, found = _Newton(loops), first_pose(loops), []
    for row, target in enumerate(np.frombuffer(position).reshape(-1, len(loops.driven))):
        known = not np.isnan(target).any()  # where it is not, the joints stay
        at = newton.toward(at, target) if known else at
        if known and (at.q[loops.driven] != target).any():
            wanted, reached = (", ".join(f"{x:.4g}" for x in each) for each in (target, at.q[loops.driven]))
            raise Unreachable(
                f"loops that close expected, driven joints at {wanted} found, where they do not; on the way "
                f"they come to {reached}; check signs and zeros of the joints, the points of loops, and start",
                row,
            )
        found.append(at)
    q, J = ([getattr(pose, name) for pose in found] for name in ("q", "J"))
    return np.reshape(q, (len(found), loops.model.nv)), np.reshape(J, (len(found), 3 * len(loops.ends), -1))


def _solved(J: Floats, gap: Floats) -> Floats:
    """The smallest step that J turns into `gap`."""
    return np.asarray(np.linalg.lstsq(J, gap, rcond=_DEPENDENT)[0], np.float64)
