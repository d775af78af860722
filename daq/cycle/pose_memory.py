"""Memory of where each drive stood last: a joint that comes back whole motor turns off is refused before it moves.

An encoder that loses a turn while its drive is off shows a pose that looks right and is wrong by a turn of the motor.
"""

import json
import math
import os
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

from drivers.protocol import CheckResult, Identity, Verdict
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.rig import Rig

FOLDER = "DELTA_WORKBENCH_POSES"
"""Environment variable with the folder; empty: no pose is kept."""
ACCEPT = "pose"
"""Name by which a pose that differs by whole turns is accepted."""
_TURN_TOLERANCE = 0.05
"""Deviation from a whole number of motor turns that still counts as one. An arm that sank while off seldom stands so
near one, a lost turn always does."""


def folder() -> Path | None:
    """The folder of the poses, which may not exist yet; None if none are kept."""
    named = os.environ.get(FOLDER)
    if named is not None:
        return Path(named).expanduser() if named else None
    from platformdirs import user_state_path

    return user_state_path("delta-workbench") / "poses"


@dataclass(frozen=True)
class _Joint:
    """Where one joint stands, and where it stood."""

    identity: Identity
    file: Path | None
    """None: nothing is kept of this drive."""
    position: float
    """[rad or m]."""
    last: float | None
    """[rad or m]; None: not known."""
    turns: float
    """Motor turns from there to here."""
    unit: str
    """Of positions."""

    @property
    def is_off(self) -> bool:
        whole = round(self.turns)
        return whole != 0 and abs(self.turns - whole) <= _TURN_TOLERANCE


class PoseMemory:
    """Poses of the drives of one rig."""

    def __init__(self, rig: Rig, identities: Sequence[Identity]) -> None:
        """`identities` tell where the joints stand."""
        self._rig = rig
        self._joints = [self._recall(identity) for identity in identities]

    def _recall(self, identity: Identity) -> _Joint:
        drive, unit = self._rig.drives[identity.joint - 1], self._rig.position_units[identity.joint - 1]
        file = _file(self._rig, identity)
        here = math.nan if identity.position is None else identity.position
        counts = None if file is None or identity.position is None else _kept_counts(file, identity)
        if counts is None:
            return _Joint(identity, file, here, None, 0.0, unit)
        # Counts are compared, which a corrected zero_offset, gear or sign does not change.
        turns = (drive.to_counts(here) - counts) / drive.counts_per_turn
        return _Joint(identity, file, here, drive.to_position(counts), turns, unit)

    def check(self, accepted: frozenset[str] = frozenset()) -> None:
        """Refuse a pose outside the joint limits, and, unless it is accepted, one that is whole motor turns off.

        Raises:
            BadInput: with both poses.
        """
        limits = self._rig.limits
        for joint in self._joints:
            if joint.position < limits.joint_min or joint.position > limits.joint_max:
                raise BadInput(
                    f"{_place(joint)}, outside {limits.joint_min:g} to {limits.joint_max:g} {joint.unit}; check "
                    "zero_offset, gear and sign, or home it"
                )
            if joint.is_off and ACCEPT not in accepted:
                raise BadInput(
                    f"{_place(joint)}: {round(joint.turns):+d} turn(s) of its motor, as of an encoder that lost "
                    "count while off; look at the joint: home the drive or restore its zero if it has not moved, "
                    "--accept pose if it has"
                )

    def results(self) -> Iterator[CheckResult]:
        """For each joint the pose beside the last one, with the file that holds it."""
        for joint in self._joints:
            if joint.file is not None and joint.identity.position is not None:
                known = "not known" if joint.last is None else f"{joint.last:.4f} {joint.unit}"
                found = f"{joint.position:.4f} {joint.unit}"
                if joint.is_off:
                    found += f", {round(joint.turns):+d} turn(s) of the motor away: look at the joint (--accept pose)"
                verdict: Verdict = "problem" if joint.is_off else "noted"
                where = f"joint {joint.identity.joint} ({joint.identity.address})"
                yield CheckResult(where, "pose", f"last {known} ({joint.file})", found, verdict)

    def keep(self, position: Sequence[float]) -> None:
        """Keep where the joints stand now, `position` (dof,) [rad or m]; NaN: not known. A folder that cannot be
        written keeps nothing."""
        for joint, here in zip(self._joints, position, strict=True):
            if joint.file is None or math.isnan(here):
                continue
            drive = self._rig.drives[joint.identity.joint - 1]
            document = {
                "schema": 1,
                "counts": round(drive.to_counts(here)),
                "started": joint.identity.started,
                "time": datetime.now(UTC).isoformat(timespec="seconds"),
            }
            try:
                joint.file.parent.mkdir(parents=True, exist_ok=True)
                with replacement(joint.file) as draft:
                    draft.write_text(json.dumps(document) + "\n", encoding="utf-8")
            except OSError:
                return


def _place(joint: _Joint) -> str:
    before = "" if joint.last is None else f", {joint.last:.4f} {joint.unit} when it was last seen"
    return f"joint {joint.identity.joint} stands at {joint.position:.4f} {joint.unit}{before}"


def _file(rig: Rig, identity: Identity) -> Path | None:
    place = folder()
    # A simulated drive of this program begins anew with each run.
    if place is None or identity.lockstep or (identity.simulated and not identity.started):
        return None
    device = (identity.vendor_id, identity.product_code, identity.serial_number)
    # Axes of one node have one serial number.
    known = "-".join(f"{number:08X}" for number in device) + "".join(identity.address.partition(" axis")[1:])
    name = known if identity.serial_number else f"{rig.name} {identity.address}"
    return place / f"{re.sub(r'[^A-Za-z0-9-]+', '-', name)}.json"


def _kept_counts(file: Path, identity: Identity) -> int | None:
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        counts = document["counts"]
        # A simulated drive that was started again is another one.
        return counts if isinstance(counts, int) and document["started"] == identity.started else None
    except (OSError, ValueError, TypeError, KeyError):
        return None
