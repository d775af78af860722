"""The section [[drives]] of one joint in a proposed rig file."""

import math
from collections.abc import Iterator, Sequence

from daq.proposal.choices import TorqueSource, mode_of, motor_voltage, name_of
from daq.proposal.facts import DriveFacts
from daq.proposal.text import CHECK, Key, comment
from drivers.canopen import pdo, readiness, setup
from drivers.canopen.roles import ROLES
from drivers.canopen.sdo import SdoWrite
from drivers.canopen.units import OBJECTS, gear_ratio, position_units_per_turn
from recordings.config import validated
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

_COUNTS, _GEAR, _RATED_TORQUE, _RATED_CURRENT, _VOLTAGE_SCALE = 8192, 21.0, 20.0, 5.0, 0.001
"""Placeholders for what drives do not state."""
_STAY_POWERED = 6
"""Option of 605Ah."""


class DriveSection:
    """The section [[drives]] of one joint."""

    def __init__(self, joint: int, facts: DriveFacts, source: TorqueSource | None) -> None:
        """Raises BadInput if the drive cannot be driven."""
        self._joint, self._facts, self._source = joint, facts, source
        self.origin = facts.origin
        self.notes: list[str] = []
        """What the user must know and decide."""
        self._mode, self._why = mode_of(facts)
        self._values = {address: facts.value(*address) or 0 for address in OBJECTS if address in facts}
        self._gear = gear_ratio(self._values)
        if self._gear == 1:
            self._gear = None
        self._counts = next(iter(position_units_per_turn(self._values).items()), None)
        self._dictionary = facts.dictionary(self._drive())

    def _drive(self) -> Drive:
        """The drive as it is proposed."""
        keys: dict[str, object] = {"node_id": self._facts.node_id, "mode": self._mode}
        keys |= {"counts_per_turn": self._counts_per_turn, "gear": self._gear or _GEAR}
        if self._source is not None:
            keys["torque_source"] = self._source
        if self._source == "voltage":
            keys["voltage"] = self._voltage()[0]
        return validated(keys, Drive, f"proposal for {self._facts.origin}")

    def _voltage(self) -> tuple[dict[str, object], str]:
        """Key `voltage` and its comment."""
        voltage = motor_voltage(self._facts)
        assert voltage is not None
        index, sub = voltage.address
        transfer = "pdo" if voltage.mappable else "sdo"
        keys = {"index": index, "sub": sub, "scale": voltage.scale or _VOLTAGE_SCALE, "transfer": transfer}
        doubt = "" if voltage.scale else CHECK + "scale [V per count]; "
        return keys, f'{doubt}"{voltage.name}"'

    @property
    def _counts_per_turn(self) -> int:
        return _COUNTS if self._counts is None else max(1, round(self._counts[1]))

    def torque_per_ampere(self) -> float | None:
        """Joint torque per motor current by the drive's ratings [N m/A]."""
        torque, current = self._facts.value(0x6076), self._facts.value(0x6075)
        return torque / current * (self._gear or _GEAR) if torque and current else None

    def lines(self, draft: Rig | None, *, explain: bool) -> Iterator[str]:
        """Lines of the file; `draft`: the rig, to find what the drive will refuse; without `explain` the lines that
        explain are left out: an equal drive has them."""
        facts = self._facts
        yield from ("", f"[[drives]]  # joint {self._joint}: {facts.name}, from {facts.origin}")
        if explain:
            yield from comment(self._pdo_text())
        for key in [*self._machine(), *self._operation(), *self._measurement()]:
            yield from key.lines()
        yield from self._missing([] if draft is None else self._refused(draft), explain=explain)
        if explain:
            yield from self._settings()
        if facts.eds:
            yield from Key("eds", f'"{facts.eds}"', "uncomment: daq check then knows the limits", False).lines()
        if facts.file:
            yield from Key("dcf", f'"{facts.file}"', "uncomment to write its values before each run", False).lines()

    def _machine(self) -> Iterator[Key]:
        yield Key("node_id", str(self._facts.node_id))
        stated = self._counts
        if stated is None:
            comment = CHECK + "position units (usually encoder counts) per turn of the motor"
            self.notes.append("no drive states its encoder's resolution in use: counts_per_turn is a placeholder")
        else:
            comment = f"position units per turn of the motor, by {stated[0]}"
            if not math.isclose(stated[1], self._counts_per_turn):
                comment = f"{CHECK}{stated[1]:.9g} by {stated[0]}, which is no whole number"
        yield Key("counts_per_turn", str(self._counts_per_turn), comment)
        comment = "6091h" if self._gear else CHECK + "motor turns per turn of the joint"
        yield Key("gear", f"{float(self._gear or _GEAR):.9g}", comment)
        yield Key("sign", "1", CHECK + "-1 where counts fall as the elbow rises")
        yield Key("zero_offset", "0.0", CHECK + "joint angle at position 0 [rad]")

    def _operation(self) -> Iterator[Key]:
        yield Key("mode", f'"{self._mode}"', self._why)
        if not self._facts.value(0x6502):
            yield Key("assume_mode", "true", "uncomment to try this mode; the drive does not list its modes", False)
            self.notes.append("6502h gives no modes: uncomment assume_mode to try the mode")
        if self._facts.value(0x605A) == _STAY_POWERED:
            comment = "605Ah as it is: quick stop ramp, then powered until the host is done"
            yield Key("quick_stop_option", f"{_STAY_POWERED}", comment)
        units = self._dictionary.units
        for problem in units.problems:
            self.notes.append(f"{self._facts.origin}: {problem}")
        if units.question and self._dictionary.has_ramp:
            comment = "uncomment the unit of 6085h that the manual states: a wrong one makes stops far too hard"
            yield Key("units", '{ acceleration = "counts/s^2" }', comment, False)
            self.notes.append(
                "the unit of accelerations (60AAh) is not stated: set units in [[drives]] by the manual"
            )

    def _measurement(self) -> Iterator[Key]:
        facts = self._facts
        if self._source == "voltage":
            keys, text = self._voltage()
            values = {**keys, "index": f"0x{keys['index']:04X}", "transfer": f'"{keys["transfer"]}"'}
            yield Key("voltage", f"{{ {', '.join(f'{key} = {value}' for key, value in values.items())} }}", text)
        elif self._source is not None:
            yield Key("torque_source", f'"{self._source}"')
        if self._source == "torque_actual":
            yield self._rated_torque()
        elif self._source == "current_actual":
            rated = facts.value(0x6075)
            comment = f"A; 6075h = {rated} mA" if rated else f"A; {CHECK}6075h gives no value; from the type plate"
            yield Key("rated_current", f"{rated / 1000 if rated else _RATED_CURRENT:g}", comment)

    def _rated_torque(self) -> Key:
        rated = self._facts.value(0x6076)
        if not rated:
            self.notes.append("6076h gives no rated torque: rated_torque is a placeholder, so torques are relative")
            return Key("rated_torque", f"{_RATED_TORQUE}", f"N m; {CHECK}rated torque of the motor * gear")
        joint = rated / 1000 * (self._gear or _GEAR)
        return Key("rated_torque", f"{joint:.6g}", f"N m at the joint; 6076h = {rated} mN m * gear")

    def _refused(self, draft: Rig) -> list[SdoWrite]:
        """What the set-up writes to this drive and its limits in the EDS exclude."""
        drive = draft.drives[self._joint - 1]
        try:
            writes = setup.own_writes(draft, drive, self._facts.dictionary(drive))
        except BadInput as error:
            self.notes.append(f"{self.origin}: {error}")
            return []
        return [write for write in writes if not self._facts.accepts(write.index, write.sub, write.value)]

    def _missing(self, refused: Sequence[SdoWrite], *, explain: bool) -> Iterator[str]:
        missing = readiness.missing_for_safety(self._dictionary)
        for write in refused:
            role = ROLES.get(write.index)
            if role is not None and role.role == "safety" and write.index not in missing:
                missing.append(write.index)
            if role is None or role.role != "convenience":
                low, high = self._facts.limits(write.index, write.sub)
                span = f"{'' if low is None else low}...{'' if high is None else high}"
                name = f"{write.index:04X}:{write.sub:02X}"
                self.notes.append(f"{self.origin}: {name} accepts {span} in this file, {write.value} will be written")
        missing.sort()
        if not missing:
            return
        if explain:
            yield from comment("Not in this drive or not usable, so without its protection:")
            for index in missing:
                role = ROLES[index]
                yield from comment(f"- {index:04X}h {role.meaning}: {role.loss}; {role.instead}.")
        listed = ", ".join(f'"{index:04X}"' for index in missing)
        yield from Key("accept_missing", f"[{listed}]", "uncomment to drive without them", False).lines()
        self.notes.append(f"objects of safety are missing ({listed}): read what that means before accept_missing")

    def _settings(self) -> Iterator[str]:
        """Comment on the drive's present limits in SI units."""
        facts, drive = self._facts, self._dictionary.drive
        counts, acceleration = abs(drive.counts_per_radian), self._dictionary.units.acceleration
        parts = []
        low, high = facts.value(0x607D, 1), facts.value(0x607D, 2)
        if low is not None and high is not None and low < high:
            parts.append(f"607Dh from {low / counts:.4g} to {high / counts:.4g} rad")
        if window := facts.value(0x6065):
            parts.append(f"6065h = {window / counts:.4g} rad")
        if acceleration is not None and (deceleration := facts.value(0x6085)):
            parts.append(f"6085h = {deceleration / acceleration.per_radian:.4g} rad/s^2 ({acceleration.name})")
        if parts:
            yield from comment(f"Its own limits, from the joint's zero ({facts.values}): {'; '.join(parts)}.")

    def _pdo_text(self) -> str:
        drive = self._dictionary.drive
        try:
            received = pdo.rpdos(drive, self._dictionary)
            transmitted = pdo.tpdos(drive, self._dictionary) if self._source else {}
        except BadInput as error:
            raise BadInput(f"{self._facts.origin}: {error}") from None
        maps = [("RPDO", number, mapped) for number, mapped in received.items()]
        maps += [("TPDO", number, [item.mapped for item in fields]) for number, fields in transmitted.items()]
        parts = []
        for kind, number, mapped in maps:
            names = ", ".join(name_of((each >> 16, each >> 8 & 0xFF)) for each in mapped)
            parts.append(f"{kind} {number + 1}: {names} ({sum(map(pdo.size_of, mapped))} bytes)")
        return "PDO map, written at the start: " + "; ".join(parts) + "."
