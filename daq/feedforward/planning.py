"""The torque of a run, computed before power is switched on."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np

from daq.feedforward.segments import lead_in
from daq.feedforward.source import PlannedTorque, TorqueSource
from drivers.protocol import Identity, Report
from recordings.errors import BadInput
from recordings.recording import Floats
from recordings.rig import Rig
from trajectories import Trajectory

ASSUMED_GAIN = "assumed-gain"
"""Name by which an assumed torque gain is accepted."""


class Feedforward:
    """Feed-forward of one run."""

    def __init__(self, source: TorqueSource, rig: Rig, accepted: frozenset[str], report: Report) -> None:
        """`accepted`: what the user accepts by name."""
        self.source = source
        self._rig, self._accepted, self._report = rig, accepted, report

    def check_drives(self, identities: tuple[Identity, ...]) -> None:
        """Refuse real drives whose torque is known only by an assumed gain.

        Raises:
            BadInput: the gain is assumed, and not accepted by name.
        """
        drives, torque = self._rig.drives, self._rig.torque
        if any(drive.torque_source == "none" for drive in drives):
            raise BadInput('--feedforward needs a torque to watch, torque_source = "none" found in the rig file')
        by_gain = any(drive.torque_source == "voltage" for drive in drives) and torque.gain_source == "assumed"
        real = any(not identity.simulated for identity in identities)
        if real and by_gain and ASSUMED_GAIN not in self._accepted:
            raise BadInput(
                '--feedforward needs torques in N m: the rig file says gain_source = "assumed", so those of the '
                f"model are known up to a factor; see `ident calibrate-gain`, or accept it: --accept {ASSUMED_GAIN}"
            )

    def plan(self, start: float, approach: Floats, trajectory: Trajectory, wait: Callable[[], None]) -> PlannedTorque:
        """Compute the torque of the approach (m, dof) [rad] and the trajectory, cut off at limits.torque_offset.

        `start`: when the drives could be enabled, after the first SYNC [s]. `wait` passes time until it is there.

        Raises:
            BadInput: it cannot be computed, or it is none of this rig and motion.
        """
        source = self.source
        with ThreadPoolExecutor(1) as executor:
            future = executor.submit(source.compute, start + lead_in(self._rig), approach, trajectory)
            try:
                while not future.done():
                    wait()
            except BaseException:
                source.cancel()
                raise
        planned = future.result()
        self._report(
            "info",
            "feed-forward",
            f"{source.path.name} (SHA-256 {source.digest}), table SHA-256 {planned.table_digest}",
        )
        self._report_cut(planned)
        largest = self._rig.limits.torque_offset * self._rated
        return replace(
            planned,
            approach=None if planned.approach is None else np.clip(planned.approach, -largest, largest),
            stream=np.clip(planned.stream, -largest, largest),
        )

    @property
    def _rated(self) -> Floats:
        return np.array([drive.rated_torque for drive in self._rig.drives])

    def _report_cut(self, planned: PlannedTorque) -> None:
        limit = self._rig.limits.torque_offset
        share = np.abs(planned.stream) / self._rated
        beyond = (share > limit).any(axis=1).mean()
        if beyond:
            self._report(
                "warning",
                "feed-forward",
                f"{beyond:.0%} of the torques are cut off at {limit:g} of the rated torque (limits.torque_offset), "
                f"the largest is {share.max():.2f} of it",
            )
