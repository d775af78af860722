"""The section [[drives]] of one joint in a proposed rig file."""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from daq.proposal.choices import TorqueSource, mode_of, name_of
from daq.proposal.facts import DriveFacts
from daq.proposal.names import motor_voltage, named_acceleration, states
from daq.proposal.text import ASK, ASSUMED, NAMED, STATED, UNKNOWN, Key, comment
from drivers.canopen import pdo, readiness
from drivers.canopen.dictionary import DriveDictionary
from drivers.canopen.readiness import DriveFinding
from drivers.canopen.requirements import ROWS, TABLE
from drivers.canopen.sdo import format_address
from drivers.canopen.units import ELECTRONIC_GEAR, OBJECTS, gear_ratio, position_units_per_turn
from recordings.config import validated
from recordings.errors import BadInput
from recordings.rig import Drive, Rig

PLACEHOLDERS: Mapping[str, object] = {
    **{"counts_per_turn": 8192, "gear": 21.0, "rated_torque": 20.0, "rated_current": 5.0, "per_ampere": 1.0},
    **{"scale": 0.001, "acceleration": None},
}
"""What stands for ASK, by key, where only the sizes of objects and the load of the bus are computed."""
_STAY_POWERED = 6
"""Option of 605Ah."""


def with_placeholders(content: Any, key: str = "") -> Any:
    """Content of a rig file with placeholders for what is asked; `key`: its key."""
    if isinstance(content, dict):
        return {name: with_placeholders(value, name) for name, value in content.items()}
    if isinstance(content, list):
        return [with_placeholders(value, key) for value in content]
    return PLACEHOLDERS[key] if content == ASK else content


class DriveSection:
    """The section [[drives]] of one joint."""

    def __init__(self, joint: int, facts: DriveFacts, source: TorqueSource) -> None:
        """Raises BadInput if the drive cannot be driven."""
        self._joint, self._facts, self._source = joint, facts, source
        self.origin, self.axis = facts.origin, facts.axis
        self.notes: list[str] = []
        """What the user must know and decide."""
        self._mode, self._why = mode_of(facts)
        self._values = {address: facts.value(*address) or 0 for address in OBJECTS if address in facts}
        self._gear = gear_ratio(self._values)
        if self._gear == 1:
            self._gear = None
        self._counts = next(iter(position_units_per_turn(self._values).items()), None)
        self._dictionary = facts.dictionary(self._drive())
        self._named = named_acceleration(facts) if self._asks_acceleration else None
        if self._named is not None:
            self._dictionary = facts.dictionary(self._drive(units={"acceleration": self._named[0]}))

    @property
    def _asks_acceleration(self) -> bool:
        """Whether the unit of accelerations must be known and nothing says it."""
        return bool(self._dictionary.units.question) and self._dictionary.has_ramp

    def _drive(self, **further: object) -> Drive:
        """The drive as it is proposed, with placeholders for what is asked, and `further` keys."""
        keys: dict[str, object] = {"node_id": self._facts.node_id, "axis": self._facts.axis, "mode": self._mode}
        keys |= {"counts_per_turn": self._counts_per_turn, "gear": self._gear or ASK, "torque_source": self._source}
        if self._source == "voltage":
            keys["voltage"] = self._voltage()[0]
        return validated(with_placeholders(keys | further), Drive, f"proposal for {self._facts.origin}")

    def _voltage(self) -> tuple[dict[str, object], str]:
        """Key `voltage` and its comment."""
        voltage = motor_voltage(self._facts)
        assert voltage is not None
        index, sub = voltage.address
        transfer = "pdo" if voltage.mappable else "sdo"
        keys: dict[str, object] = {"index": index, "sub": sub, "scale": voltage.scale or ASK, "transfer": transfer}
        doubt = "" if voltage.scale else f"; {UNKNOWN}scale [V per count]"
        return keys, f'{NAMED}"{voltage.name}"{doubt}'

    @property
    def _counts_per_turn(self) -> int | str:
        return ASK if self._counts is None else max(1, round(self._counts[1]))

    def torque_per_ampere(self) -> tuple[float | None, str]:
        """Joint torque per motor current by the drive's ratings [N m/A], None where it is not known; and why."""
        torque, current = self._facts.value(0x6076), self._facts.value(0x6075)
        if torque and current and self._gear:
            return torque / current * self._gear, "6076h / 6075h * gear"
        known = "torque constant of the motor [N m/A], by its type plate"
        if torque and current:
            known = f"6076h / 6075h = {torque / current:.6g} N m/A of the motor"
        self.notes.append(f'per_ampere is "?", because no drive says it: {known}, times the gear')
        return None, f"{known}, times the gear"

    def lines(self, draft: Rig | None, *, explain: bool) -> Iterator[str]:
        """Lines of the file; `draft`: the rig, to find what the drive will refuse; without `explain` the lines that
        explain are left out: an equal drive has them."""
        facts = self._facts
        yield from ("", f"[[drives]]  # joint {self._joint}: {facts.name}, from {facts.origin}")
        if explain and self.axis == 1:  # where further axes have theirs, few files say
            yield from comment(self._pdo_text())
        for key in [*self._machine(), *self._operation(), *self._measurement()]:
            yield from key.lines()
        yield from self._missing([] if draft is None else self._findings(draft), explain=explain)
        if explain:
            yield from self._settings()
        if listed := ", ".join(states(facts)):
            yield from Key("watched", f"[{listed}]", "uncomment to record their changes", False).lines()
        if facts.eds:
            yield from Key("eds", f'"{facts.eds}"', "uncomment: daq check then knows the limits", False).lines()
        if facts.file:
            yield from Key("dcf", f'"{facts.file}"', "uncomment to write its values before each run", False).lines()

    def _machine(self) -> Iterator[Key]:
        given = ASSUMED + "as --nodes says" if self._facts.eds else STATED + "it answers under this id"
        yield Key("node_id", str(self._facts.node_id), given)
        if self._facts.axis > 1:
            yield Key("axis", str(self._facts.axis), STATED + "its objects are there")
        yield self._resolution()
        if self._gear:
            yield Key("gear", f"{self._gear:.9g}", STATED + "6091h")
        else:
            yield self._asked("gear", "motor turns per turn of the joint")
        yield Key("sign", "1", ASSUMED + "-1 where counts fall as the elbow rises; daq jog shows it")
        yield Key("zero_offset", "0.0", ASSUMED + "joint angle at position 0 [rad]; daq check shows the present one")

    def _asked(self, name: str, meaning: str) -> Key:
        """A key that nothing says."""
        self.notes.append(f'{name} is "?", because no drive says it: {meaning}')
        return Key(name, f'"{ASK}"', UNKNOWN + meaning)

    def _resolution(self) -> Key:
        if self._counts is None:
            return self._asked("counts_per_turn", "position units (usually encoder counts) per turn of the motor")
        source, counts = self._counts
        comment = f"{STATED}position units per turn of the motor, by {source}"
        if doubt := readiness.position_doubt(self._dictionary):
            comment = f"{ASSUMED}position units per turn of the motor, by {source}. {doubt}"
            self.notes.append(f"counts_per_turn is assumed: {doubt}")
        elif source == ELECTRONIC_GEAR:
            comment = f"{ASSUMED}position units per turn of the motor, by {source}"
            self.notes.append(f"counts_per_turn is assumed: {counts:.9g} by {source}")
        elif not math.isclose(counts, round(counts)):
            comment = f"{ASSUMED}{counts:.9g} by {source}, which is no whole number"
        return Key("counts_per_turn", str(self._counts_per_turn), comment)

    def _operation(self) -> Iterator[Key]:
        yield Key("mode", f'"{self._mode}"', self._why)
        if not self._facts.value(0x6502):
            yield Key("assume_mode", "true", "uncomment to try this mode; the drive does not list its modes", False)
        yield from self._options()
        if self._named is not None:
            yield Key("units", f'{{ acceleration = "{self._named[0]}" }}', f'{NAMED}"{self._named[1]}"')
        elif self._asks_acceleration:
            question = self._dictionary.units.question
            self.notes.append(question)
            yield Key(
                "units", f'{{ acceleration = "{ASK}" }}', f"{UNKNOWN}{question}; a wrong one makes stops far too hard"
            )

    def _options(self) -> Iterator[Key]:
        """Reactions of the drive where it, or its file, has others than the usual ones."""
        if self._facts.value(0x605A) == _STAY_POWERED:
            comment = f"{STATED}605Ah as it is: quick stop ramp, then powered until the host is done"
            yield Key("quick_stop_option", f"{_STAY_POWERED}", comment)
            return
        for row in TABLE:
            usual = Drive.model_fields[row.key].default if row.choices else None
            fitting = [value for value in row.choices if not self._dictionary.refuses(row.address, value)]
            if usual is not None and fitting and usual not in fitting:
                refusal = self._dictionary.refuses(row.address, usual)
                yield Key(
                    row.key, f"{max(fitting)}", f"{STATED}{row.address[0]:04X}h {refusal} for the usual reaction"
                )

    def _measurement(self) -> Iterator[Key]:
        if self._source == "voltage":
            keys, text = self._voltage()
            values = {**keys, "index": f"0x{keys['index']:04X}", "transfer": f'"{keys["transfer"]}"'}
            if keys["scale"] == ASK:
                values["scale"] = f'"{ASK}"'
                self.notes.append(f'the scale of the voltage is "?", because its name does not say it: {text}')
            yield Key("voltage", f"{{ {', '.join(f'{key} = {value}' for key, value in values.items())} }}", text)
            return
        if self._source == "none":
            yield Key("torque_source", '"none"', ASSUMED + "positions only, for commissioning, as --torque none says")
            return
        row = ROWS[{"torque_actual": 0x6077, "current_actual": 0x6078}[self._source], 0]
        name = self._dictionary.misnamed(row)
        doubt = f"{NAMED}{row.address[0]:04X}h is {name}, {row.meaning} by the standard"
        stated = f"{STATED}{row.address[0]:04X}h can be mapped"
        yield Key("torque_source", f'"{self._source}"', doubt if name else stated)
        yield self._rated_torque() if self._source == "torque_actual" else self._rated_current()

    def _rated_torque(self) -> Key:
        rated = self._facts.value(0x6076)
        if rated and self._gear:
            return Key(
                "rated_torque",
                f"{rated / 1000 * self._gear:.6g}",
                f"{STATED}N m at the joint; 6076h = {rated} mN m * gear",
            )
        if (0x6076, 0) not in self._facts:
            return self._asked("rated_torque", f"N m at the joint, {self._of_count(0x6077, 0x6076)}")
        known = (
            f"6076h = {rated / 1000:g} N m of the motor" if rated else "rated torque of the motor, by its type plate"
        )
        return self._asked("rated_torque", f"N m at the joint; {known}, times the gear")

    def _of_count(self, index: int, base: int) -> str:
        """What is asked where a drive has no rating of which its counts are thousandths."""
        item = self._facts.descriptions.get((0x6071, 0))
        limits = f", and 6071h takes {item.span}" if item is not None and item.is_limited else ""
        gear = ", times the gear" if base == 0x6076 else ""
        return f"by the manual: 1000 times what one count of {index:04X}h is{gear}; there is no {base:04X}h{limits}"

    def _rated_current(self) -> Key:
        rated = self._facts.value(0x6075)
        if rated:
            return Key("rated_current", f"{rated / 1000:g}", f"{STATED}A; 6075h = {rated} mA")
        if (0x6075, 0) not in self._facts:
            return self._asked("rated_current", f"A, {self._of_count(0x6078, 0x6075)}")
        return self._asked("rated_current", "A, by the motor's type plate; 6075h gives no value")

    def _findings(self, draft: Rig) -> list[DriveFinding]:
        """What the drive lacks for the rig; what the user decides is noted.

        Raises:
            BadInput: a drive that no rig file can drive.
        """
        dictionary = self._facts.dictionary(draft.drives[self._joint - 1])
        found = readiness.findings(draft, dictionary)
        found = [each for each in found if not (each.of_value and each.row and each.row.quantity in self._open)]
        self.notes += self._open_limits(dictionary)
        if fatal := [each.sentence for each in found if each.is_final]:
            raise BadInput(f"{self.origin}: {'; '.join(fatal)}")
        safety = [each for each in found if each.row is not None and each.row.role == "safety"]
        others = [each for each in found if each not in safety]
        self.notes += [each.sentence for each in others if each.verdict == "problem" or each.contradicts]
        return safety

    @property
    def _open(self) -> set[str]:
        """Quantities whose values in the drive depend on keys that are asked."""
        if self._counts is None or self._gear is None:
            return {"position", "acceleration"}
        return {"acceleration"} if self._dictionary.units.question else set()

    def _open_limits(self, dictionary: DriveDictionary) -> Iterator[str]:
        """Limits that may exclude what the keys that are asked will give."""
        for row in TABLE:
            item = dictionary.descriptions.get(row.address)
            if item is not None and item.is_limited and row.quantity in self._open and row.role != "motion":
                yield (
                    f"{format_address(*row.address)} {row.meaning}: takes {item.span}; whether it takes what the "
                    "rig file wants depends on what is asked (counts_per_turn, gear, units)"
                )

    def _missing(self, found: Sequence[DriveFinding], *, explain: bool) -> Iterator[str]:
        lines = {each.row.address[0]: each.sentence for each in reversed(found) if each.row}
        if not lines:
            return
        if explain:
            yield from comment("Not in this drive or not usable, so without its protection:")
            for index in sorted(lines):
                yield from comment(f"- {lines[index]}.")
        listed = ", ".join(f'"{index:04X}"' for index in sorted(lines))
        yield from Key("accept_missing", f"[{listed}]", "uncomment to drive without them", False).lines()
        self.notes.append(f"objects of safety are missing ({listed}): read what that means before accept_missing")

    def _settings(self) -> Iterator[str]:
        """Comment on the drive's present limits in SI units, where its own are known."""
        if self._counts is None or self._gear is None:
            return
        facts, drive = self._facts, self._dictionary.drive
        counts, acceleration = abs(drive.counts_per_radian), self._dictionary.units.acceleration
        parts = []
        low, high = facts.value(0x607D, 1), facts.value(0x607D, 2)
        if low is not None and high is not None and (low or high):
            exchanged = ", the lower one above the upper one" if low > high else ""
            parts.append(f"607Dh from {low / counts:.4g} to {high / counts:.4g} rad{exchanged}")
        if window := facts.value(0x6065):
            parts.append(f"6065h = {window / counts:.4g} rad")
        if acceleration is not None and (deceleration := facts.value(0x6085)):
            parts.append(f"6085h = {deceleration / acceleration.per_radian:.4g} rad/s^2 ({acceleration.name})")
        if parts:
            yield from comment(f"Its own limits, from the joint's zero ({facts.values}): {'; '.join(parts)}.")

    def _pdo_text(self) -> str:
        try:
            pdos = [*pdo.rpdos(self._dictionary), *pdo.tpdos(self._dictionary)]
        except BadInput as error:
            raise BadInput(f"{self._facts.origin}: {error}") from None
        parts = []
        for each in pdos:
            names = ", ".join(name_of(field.address) for field in each.fields)
            parts.append(f"{each.name}: {names} ({each.layout.size} bytes)")
        return "PDO map, written at the start: " + "; ".join(parts) + "."
