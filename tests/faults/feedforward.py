"""Faults with a feed-forward: those of the bus again, wrong models in several postures, drives that do not follow."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from daq.feedforward.source import PlannedTorque, TorqueSource
from recordings.recording import Floats
from recordings.rig import Rig, simulated_rig
from tests.daq.feedforward.given import GivenTorque
from tests.faults import canopen
from tests.faults.bridge import Saboteur
from tests.faults.campaign import Fault
from tests.faults.habits import without
from tests.faults.saboteurs import RPDO_2, alter
from trajectories import Trajectory
from trajectories.checks import torque_estimate

WRONG = "joint [123]: (the torque offset .* works against the drive|following error .* with a torque offset)"
NOT_FOLLOWED = "joint 2: the drive does not follow its torque offset"
POSTURES = ((0.0, 0.0, -0.75), (0.2, 0.1, -0.8), (-0.15, 0.2, -0.65), (0.1, -0.25, -0.7), (0.0, 0.0, -0.95))
"""Platform positions at power-on [m]."""
NORMAL: Mapping[str, float] = {}
SOFT = {"position_gain": 25.0, "velocity_gain": 30.0, "integral_time": 0.05}
ERROR_LIMIT = 2 * simulated_rig().limits.following_error


class _Model:
    """The frictionless robot of the rig file, wrong by factors; its torque is known along the approach, too."""

    path, digest = GivenTorque.path, GivenTorque.digest

    def __init__(self, rig: Rig, inertia: float, gravity: float) -> None:
        self._rig, self._factors = rig, (inertia, gravity)

    def compute(self, start: float, approach: Floats, trajectory: Trajectory) -> PlannedTorque:
        rest = np.zeros_like(approach)
        way = replace(
            trajectory,
            joint_position=approach,
            joint_velocity=rest,
            joint_acceleration=rest,
            platform=rest,
            repeat=rest,
        )
        return PlannedTorque(self._torque(way), self._torque(trajectory), "")

    def _torque(self, trajectory: Trajectory) -> Floats:
        rest = np.zeros_like(trajectory.joint_position)
        whole = torque_estimate(trajectory, self._rig)
        held = torque_estimate(replace(trajectory, joint_velocity=rest, joint_acceleration=rest), self._rig)
        inertia, gravity = self._factors
        return inertia * (whole - held) + gravity * held

    def cancel(self) -> None:
        pass


def model(inertia: float = 1.0, gravity: float = 1.0) -> Callable[[Rig, Trajectory], TorqueSource]:
    """The robot's model, its inertial torque and its gravity times factors."""
    return lambda rig, trajectory: _Model(rig, inertia, gravity)


def _offset(change: Callable[[int], int]) -> Callable[[], Saboteur]:
    """Change every torque offset of joint 2, from the beginning."""

    def cable() -> Saboteur:
        changed = canopen.number("<h", 6, change)
        saboteur = alter(RPDO_2, lambda data: changed(data) if len(data) == 8 else data)
        # Saboteurs count from START; this one begins at once.
        return lambda message, from_master, syncs: saboteur(message, from_master, 10**6)

    return cable


def _wrong(name: str, inertia: float, gravity: float, servo: Mapping[str, float] = NORMAL) -> list[Fault]:
    return [
        Fault(
            f"{name}, from {x:g}, {y:g}, {z:g} m",
            WRONG,
            1,
            feedforward=model(inertia, gravity),
            park=(x, y, z),
            servo=servo,
            error_limit=ERROR_LIMIT,
        )
        for x, y, z in POSTURES
    ]


AGAIN: tuple[Fault, ...] = tuple(
    replace(fault, name=f"feed-forward: {fault.name}", feedforward=model()) for fault in canopen.FAULTS
)
"""Faults of bus, drives, machine and host, with a good model."""

FAULTS: tuple[Fault, ...] = (
    *_wrong("model with gravity reversed", 1.0, -1.0),
    *_wrong("model three times too strong", 3.0, 3.0),
    *_wrong("soft servo, model with gravity reversed", 1.0, -1.0, SOFT),
    *_wrong("soft servo, model three times too strong", 3.0, 3.0, SOFT),
    Fault(
        "drive without torque offset",
        "60B2:00 torque offset: no such object",
        2,
        eds=without("60B2"),
        feedforward=model(),
    ),
    Fault("drive ignores its offset", NOT_FOLLOWED, 1, cable=_offset(lambda offset: 0), feedforward=model()),
    Fault("drive reverses its offset", NOT_FOLLOWED, 1, cable=_offset(lambda offset: -offset), feedforward=model()),
)
