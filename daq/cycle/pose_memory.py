"""Memory of where each drive stood last: a joint that comes back whole motor turns off is refused before it moves.

An encoder that loses a turn while its drive is off shows a pose that looks right and is wrong by a turn of the motor.
Then the joint stands a whole number of turns from its last pose, and the others where they were. A person who moves
joints does not leave all of them there: a joint at a fraction of a turn tells that somebody did, or that arms sank,
and nothing is refused. What cannot be known from poses: a turn that was lost while other joints moved, and whether a
drive was off at all.
"""

import json
import math
import os
import re
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path

from drivers.protocol import CheckResult, Identity, Report, Verdict
from recordings.errors import BadInput
from recordings.files import replacement
from recordings.rig import Drive, Rig

FOLDER = "DELTA_WORKBENCH_POSES"
"""Environment variable with the folder; empty: no pose is kept."""
ACCEPT = "pose"
"""Name by which a pose that differs by whole turns is accepted."""
_STEPS = 4
"""Encoder steps by which a joint that nobody moved may stand elsewhere: noise of the encoder, settling."""
_PLAY = 1e-3
"""The same as a share of a motor turn, for fine encoders: the play of a brake, 0.4 degrees of the motor."""
# A joint that was moved by hand stands this near a whole turn by chance 1 time in 500 (17 of 8192 steps). Only a rig
# of which one joint alone was moved, and by more than half a turn, is then refused without need.


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
    drive: Drive
    file: Path | None
    """None: nothing is kept of this drive."""
    position: float
    """[rad or m]; NaN: not known."""
    unit: str
    """Of positions."""
    kept: int | None = None
    """Encoder position when it was last seen [counts]; None: not known with this zero."""

    @property
    def turns(self) -> int | None:
        """Whole motor turns from there to here; None: it stands at a fraction of one, or is not known."""
        if self.kept is None:
            return None
        turn = self.drive.counts_per_turn
        moved = round(self.drive.to_counts(self.position)) - self.kept
        whole = round(moved / turn)
        return whole if abs(moved - whole * turn) <= max(_STEPS, _PLAY * turn) else None


class PoseMemory:
    """Poses of the drives of one rig."""

    def __init__(self, rig: Rig, identities: Sequence[Identity]) -> None:
        """`identities` tell where the joints stand."""
        limits = self._limits = rig.limits
        devices = Counter(map(_device, identities))
        self._joints = [_recall(rig, identity, is_known=devices[_device(identity)] == 1) for identity in identities]
        seen = [joint for joint in self._joints if joint.kept is not None]
        self._outside = [
            joint for joint in self._joints if joint.position < limits.joint_min or joint.position > limits.joint_max
        ]
        self._off = [joint for joint in seen if joint.turns and all(other.turns is not None for other in seen)]

    def check(self, accepted: frozenset[str] = frozenset()) -> None:
        """Refuse a pose outside the joint limits, and, unless it is accepted, one that is whole motor turns off.

        Raises:
            BadInput: with both poses.
        """
        for joint in self._outside:
            raise BadInput(
                f"joint {joint.identity.joint} stands at {self._text(joint)}, outside "
                f"{self._limits.joint_min:g} to {self._limits.joint_max:g} {joint.unit}; check zero_offset, gear and "
                "sign, or home it"
            )
        if self._off and ACCEPT not in accepted:
            places = "; ".join(f"joint {joint.identity.joint} stands at {self._text(joint)}" for joint in self._off)
            raise BadInput(
                f"{places}; no joint is a fraction of a turn from where it was; look at the joint: home the drive or "
                "restore its zero if it has not moved, --accept pose if it has"
            )

    def _text(self, joint: _Joint) -> str:
        """Where a joint stands and stood, with what that looks like."""
        here = f"{joint.position:.4f} {joint.unit}"
        if joint.kept is None:
            known = "no last pose with this zero is known: compare the angle with the joint"
            here = "angle not told, or without zero reference" if math.isnan(joint.position) else here
            return f"{here}; {known if joint.file else 'no pose is kept'}"
        counts, turn = joint.drive.to_counts(joint.position), joint.drive.counts_per_turn
        # A single-turn encoder wakes up within one turn, wherever it was.
        beyond, was_beyond = abs(counts) >= turn, abs(joint.kept) >= turn
        if joint in self._off:
            lost = "a single-turn encoder: home it after every power-up"
            cause = lost if was_beyond and not beyond else "an encoder that lost count while off"
            change = f"{joint.turns:+d} turn(s) of its motor, as of {cause}"
        elif joint.turns == 0:
            change = "where it was" + (", as of a multi-turn encoder or a drive that stayed on" if beyond else "")
        else:
            change = "moved since"
        return f"{here}, {joint.drive.to_position(joint.kept):.4f} {joint.unit} when it was last seen: {change}"

    def results(self) -> Iterator[CheckResult]:
        """For each joint the angle beside the last one, with the file that holds it."""
        # Drives simulated in lockstep may not tell where they stand: they have no past.
        for joint in (joint for joint in self._joints if joint.file or not math.isnan(joint.position)):
            verdict: Verdict = "noted" if joint.kept is None else "fine"
            if joint in (*self._off, *self._outside):
                verdict = "problem"
            elif joint.file is None:
                verdict = "accepted"
            where = f"joint {joint.identity.joint} ({joint.identity.address})"
            by = f"last pose ({joint.file or f'none: simulated, or {FOLDER} is empty'})"
            yield CheckResult(where, "absolute zero", by, self._text(joint), verdict)

    def keep(self, position: Sequence[float], report: Report) -> None:
        """Keep where the joints stand now, `position` (dof,) [rad or m]; NaN: not known."""
        for joint, here in zip(self._joints, position, strict=True):
            if joint.file is None or math.isnan(here):
                continue
            now = datetime.now(UTC).isoformat(timespec="seconds")
            document = {"schema": 2, "counts": round(joint.drive.to_counts(here)), "time": now, **_zero(joint)}
            try:
                joint.file.parent.mkdir(parents=True, exist_ok=True)
                with replacement(joint.file) as draft:
                    draft.write_text(json.dumps(document) + "\n", encoding="utf-8")
            except OSError as error:
                report("warning", f"joint {joint.identity.joint}", f"its last pose is not kept: {error}")
                return


def _recall(rig: Rig, identity: Identity, *, is_known: bool) -> _Joint:
    """`is_known`: whether its numbers are of no other drive."""
    j, file = identity.joint - 1, _file(rig, identity, is_known=is_known)
    position = math.nan if identity.position is None else identity.position
    joint = _Joint(identity, rig.drives[j], file, position, rig.position_units[j])
    if file is None or identity.position is None:
        return joint
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
        counts = document["counts"] if _zero(joint).items() <= document.items() else None
    except (OSError, ValueError, TypeError, KeyError, AttributeError):
        return joint
    return replace(joint, kept=counts if isinstance(counts, int) else None)


def _zero(joint: _Joint) -> dict[str, float]:
    """What an encoder position depends on: where one of these differs, the memory begins anew. A simulated drive that
    was started again is another one."""
    keys = ("zero_offset", "counts_per_turn", "gear", "sign")
    return {"started": joint.identity.started, **{key: getattr(joint.drive, key) for key in keys}}


def _device(identity: Identity) -> str:
    """Numbers of a drive; axes of one node have one serial number."""
    numbers = (identity.vendor_id, identity.product_code, identity.serial_number)
    return "-".join(f"{number:08X}" for number in numbers) + "".join(identity.address.partition(" axis")[1:])


def _file(rig: Rig, identity: Identity, *, is_known: bool) -> Path | None:
    place = folder()
    # A simulated drive of this program begins anew with each run.
    if place is None or identity.lockstep or (identity.simulated and not identity.started):
        return None
    # Some makers give all drives one number.
    name = _device(identity) if identity.serial_number and is_known else f"{rig.name} {identity.address}"
    return place / f"{re.sub(r'[^A-Za-z0-9-]+', '-', name)}.json"
