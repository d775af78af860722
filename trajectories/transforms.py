"""Transforms between the links of a robot along its motion, for programs that draw it."""

from collections.abc import Iterator
from functools import cached_property

import numpy as np

from recordings.description import PLATFORM, Frame, TransformEncoder, frames, placed, urdf_of
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import kinematics


class Transforms:
    """The links of a rig's mechanism that move, placed by the positions of its joints."""

    def __init__(self, rig: Rig) -> None:
        urdf = urdf_of(rig)
        self._rig = rig
        self.frames: tuple[Frame, ...] = (
            () if urdf is None else tuple(each for each in frames(urdf) if each.moves != "fixed")
        )
        """None for a mechanism without a URDF."""

    def placed(self, position: Floats) -> dict[str, tuple[Floats, Floats]]:
        """Place (n, 3) [m] and quaternion (n, 4) of each frame, by name, at joint positions (n, dof) [rad or m].

        Raises:
            Unreachable: the mechanism does not close.
        """
        joints = self._joints(position)
        rest = np.zeros(len(position))
        return {frame.child: placed(frame, joints.get(frame.joint, rest)) for frame in self.frames}

    def messages(self, stamps_ns: list[int], position: Floats) -> Iterator[tuple[int, bytes]]:
        """Yield stamp [ns] and message of /tf at each of the joint positions (n, dof) that is known."""
        if not self.frames:
            return
        known = np.isfinite(position).all(axis=1)
        at = self.placed(position[known])
        for index, stamp in enumerate(np.array(stamps_ns, np.int64)[known].tolist()):
            yield (
                stamp,
                self._encoder.pack(stamp, {name: (place[index], turn[index]) for name, (place, turn) in at.items()}),
            )

    @cached_property
    def _encoder(self) -> TransformEncoder:
        return TransformEncoder(self.frames)

    def _joints(self, position: Floats) -> dict[str, Floats]:
        """Position (n,) of each joint of the URDF that is not at rest in its origin [rad or m]."""
        rig = self._rig
        driven = dict(zip(rig.joints or rig.joint_names, position.T, strict=True))
        if rig.mechanism != "delta":
            return driven | {name: np.full(len(position), value) for name, value in rig.fixed.items()}
        geometry = rig.geometry
        P = kinematics.forward(geometry, position)
        for number, (phi, theta) in enumerate(zip(geometry.phi, position.T, strict=True), start=1):
            cos, sin = np.cos(theta), np.sin(theta)
            # The rod in the frame of its limb, then in that of its arm.
            x = P[:, 0] * np.cos(phi) + P[:, 1] * np.sin(phi) + geometry.r - geometry.R - geometry.L1 * cos
            y = P[:, 1] * np.cos(phi) - P[:, 0] * np.sin(phi)
            z = P[:, 2] - geometry.L1 * sin
            along, up = x * cos + z * sin, z * cos - x * sin
            driven[f"lift_{number}"] = np.arctan2(-up, along)
            driven[f"swing_{number}"] = np.arctan2(y, np.hypot(along, up))
        return driven | dict(zip(PLATFORM, P.T, strict=True))
