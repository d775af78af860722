"""Preparation of a drive for the cycle: power off, fault reset, DCF, set-up, and what must be true before power."""

import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from drivers import cia402
from drivers.canopen import dcf, readiness, setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.dictionary import DriveDictionary, read_dictionary, standard_dictionary
from drivers.canopen.node_axes import AXES
from drivers.canopen.pdo import is_foreign, switch_off
from drivers.canopen.requirement import Requirement
from drivers.canopen.requirements import MODES, PDO, row_of
from drivers.canopen.sdo import ObjectRefused, SdoWrite, format_address
from drivers.protocol import Power, Report
from recordings.errors import BadInput, RunFailed
from recordings.rig import Rig
from recordings.schemas import Level

_RESTART_TIMEOUT = 3.0
"""Time that a drive may take to answer again after NMT "reset communication" [s]."""
_RESET_COMMUNICATION = 0x82
_PERIOD = 0x60C2
_LARGEST_PDO = 8
"""[bytes]."""
_COUNTED = "counted in the bus load"


@contextmanager
def said_once(report: Report) -> Iterator[Report]:
    """Give a report that says each text once, at the end of the block, with the names of all drives that it is of."""
    told: dict[tuple[Level, str], list[str]] = {}
    try:
        yield lambda level, name, text: told.setdefault((level, text), []).append(name)
    finally:
        for (level, text), names in told.items():
            report(level, ", ".join(names), text)


def silence_other_axes(axes: Sequence[CanopenAxis], report: Report) -> list[int]:
    """Switch off the PDOs of the axes of one node that the rig does not have; returns as `Preparation.set_up`.

    `axes`: those that it has.
    """
    kept, first = list[int](), axes[0]
    for number in sorted({*range(1, AXES + 1)} - {axis.drive.axis for axis in axes}):
        sdo, drive = first.sdo.of_axis(number), first.drive.model_copy(update={"axis": number})
        if not sdo.has(0x6040, 0):
            continue
        for write in switch_off(read_dictionary(drive, sdo)):
            try:
                sdo.write(write)
            except ObjectRefused:
                report("warning", first.name, f"a PDO of axis {number} of its node stays on: {_COUNTED}")
                kept.append(_LARGEST_PDO)
    return kept


class Preparation:
    """Preparation of one drive."""

    def __init__(self, rig: Rig, axis: CanopenAxis, report: Report, decided: bool) -> None:
        """`decided`: see `Amplifiers.configure`."""
        self._rig = rig
        self._axis = axis
        self._sdo = axis.sdo
        self._report = report
        self._decided = decided
        self._dictionary = standard_dictionary(axis.drive)
        """Objects and values of the drive before the writes that follow."""

    def switch_off(self) -> None:
        """Read the drive's dictionary; switch off a drive that another program left with power.

        Raises:
            RunFailed: it stays powered.
        """
        self._dictionary = read_dictionary(self._axis.drive, self._sdo)
        if not self._dictionary.tells_status:
            return  # which is one of the reasons why it does not fit
        self._axis.read_state()
        if not self._axis.has_torque:
            return
        self._report("warning", self._axis.name, f"found in '{self._state}'; it is stopped and switched off first")
        for command in (cia402.Controlword.QUICK_STOP, cia402.Controlword.DISABLE_VOLTAGE):
            self._axis.stop_by(command)
        if self._axis.has_torque:
            raise RunFailed(f"{self._axis.name} stays in '{self._state}'; cut its power by hand")

    def check_fit(self) -> None:
        """Compare the drive's dictionary, with the values of the DCF, with the rig file.

        Raises:
            BadInput: the drive does not fit, or lacks what the rig file does not accept as missing.
        """
        self._refuse_misfit(self._dictionary.after(dcf.configuration(self._axis.drive)))

    def _refuse_misfit(self, dictionary: DriveDictionary) -> str:
        """Raise BadInput where the drive does not fit; returns the doubt that a small motion will decide, or ""."""
        reasons = readiness.problems(self._rig, dictionary)
        if doubt := readiness.position_doubt(dictionary):
            doubt = f"position units per motor turn: {doubt}"
        if doubt and self._decided:
            reasons.append(doubt)
        if reasons:
            further = f" (and {len(reasons) - 1} more: daq check shows all)" if len(reasons) > 1 else ""
            raise BadInput(f"{self._axis.name}: {reasons[0]}{further}")
        return doubt

    def set_up(self, *, referenced: bool = True) -> list[int]:
        """Write the set-up; returns the data bytes of the PDOs that the drive did not let go of.

        `referenced`: refuse a drive without its zero reference.

        Raises:
            BadInput: as `check_fit`.
            RunFailed: the drive refuses a value, has a fault, or has no zero reference.
        """
        axis, drive = self._axis, self._axis.drive
        for write in dcf.configuration(drive):
            self._apply(write)
        # Again: a reset of the communication and the DCF have changed values.
        self._dictionary = dictionary = read_dictionary(drive, self._sdo)
        doubt = self._refuse_misfit(dictionary)
        axis.use(dictionary)
        if doubt:
            self._report("warning", axis.name, doubt)
        for finding in readiness.findings(self._rig, dictionary):
            if finding.verdict == "accepted":
                self._report("warning", axis.name, f"driven without {finding.sentence}")
        kept = [size for write in setup.own_writes(self._rig, dictionary) for size in self._apply(write)]
        mode = MODES[drive.mode]
        if not axis.confirm_mode(mode):
            self._report("warning", axis.name, f"shows no mode yet (6061h) after mode {mode} was written")
        axis.counts = self._sdo.read(0x6064, 0, "<i")
        axis.read_state()
        if axis.state is cia402.DriveState.FAULT:
            raise RunFailed(f"{axis.name}: {self._fault()} came back after the reset; remove its cause at the drive")
        # Earlier errors (such as the loss of the last master) are reported, but do not end this run.
        axis.clear_errors()
        if referenced and drive.homed is not None and not axis.is_homed():
            raise RunFailed(
                f"{axis.name} has no zero reference (object {format_address(drive.homed.index, drive.homed.sub)}, "
                f"mask 0x{drive.homed.mask:X}); home the drive first"
            )
        return kept

    @property
    def _state(self) -> str:
        return "an unknown state" if self._axis.state is None else self._axis.state.value

    # Faults

    def reset_fault(self) -> None:
        """Reset a fault; where the controlword does not help, with the communication of the whole node.

        Raises:
            RunFailed: the drive keeps its fault.
        """
        axis = self._axis
        if axis.state is not cia402.DriveState.FAULT:
            return
        fault = self._fault()
        if self._try_reset():
            self._report("info", axis.name, f"{fault}: reset by the controlword")
            return
        axis.send_nmt(_RESET_COMMUNICATION)
        self._wait_for_restart()
        axis.read_state()
        step = 'NMT "reset communication"'
        if axis.state is cia402.DriveState.FAULT:
            step += " and the controlword"
            if not self._try_reset():
                raise RunFailed(
                    f"{axis.name}: {self._fault()} is not reset within {axis.drive.fault_reset_timeout:g} s, by the "
                    f"controlword or by {step}; remove its cause at the drive, or raise fault_reset_timeout"
                )
        self._report("info", axis.name, f"{fault}: reset by {step}; the controlword alone did not help")

    def _try_reset(self) -> bool:
        """Command a fault reset, which acts only on its rising edge, and wait for it."""
        axis = self._axis
        for command in (cia402.Controlword.DISABLE_VOLTAGE, cia402.Controlword.FAULT_RESET):
            axis.command(command)
        deadline = time.monotonic() + axis.drive.fault_reset_timeout
        axis.read_state()
        while axis.power is Power.FAULT and time.monotonic() < deadline:
            axis.read_state()
        axis.command(cia402.Controlword.DISABLE_VOLTAGE)
        return axis.power is not Power.FAULT

    def _wait_for_restart(self) -> None:
        deadline = time.monotonic() + _RESTART_TIMEOUT
        while not self._sdo.count_answers():
            if time.monotonic() > deadline:
                raise RunFailed(
                    f"{self._axis.name} does not answer within {_RESTART_TIMEOUT:g} s after NMT "
                    '"reset communication"; switch its supply off and on'
                )

    def _fault(self) -> str:
        code = self._sdo.read_optional(0x603F, 0, "<H") or self._axis.error_code
        return f"fault 0x{code:04X} ({self._axis.text_of(code)})" if code else "a fault without a code"

    # The set-up

    def _apply(self, write: SdoWrite) -> list[int]:
        """Write one object; returns the size of a PDO that the drive does not let go of."""
        row, address = row_of((write.index, write.sub)), format_address(write.index, write.sub)
        try:
            self._sdo.write(write)
        except ObjectRefused as refusal:
            present = self._sdo.read_optional(write.index, write.sub, write.layout)
            if self._was_so(write, present):
                return []
            if is_foreign(write):
                self._report("warning", self._axis.name, f"a PDO ({address}) cannot be switched off: {_COUNTED}")
                return [_LARGEST_PDO]
            accepted = f"{write.index:04X}" in self._axis.drive.accept_missing
            if row.role == "convenience" or accepted:
                level, loss = ("warning", f": {row.loss}, {row.instead}") if accepted else ("info", "")
                self._report(level, self._axis.name, f"object {address} ({row.meaning}) left as it is{loss}")  # type: ignore[arg-type]
                return []
            has = "" if present is None else f"; the drive has {present}"
            raise RunFailed(f"{refusal} (value {write.value}){has}; {_advice(row, present)}") from None
        return []

    def _was_so(self, write: SdoWrite, present: int | None) -> bool:
        """Whether the object had the value before it was refused; of the objects of a DCF, whether it has it now."""
        before = self._dictionary.value((write.index, write.sub), write.layout)
        value = present if before is None else before
        return value is not None and not (value ^ write.value) & write.mask


def _advice(row: Requirement, present: int | None) -> str:
    if row.address[0] == _PERIOD:
        rates = "1000 Hz" if present == 1 else "one that it accepts"
        return f"it interpolates over another period: choose another --rate, e.g. {rates}"
    if row is PDO:
        return "where its mapping cannot be changed, map the objects by the drive's own tool, and let it store them"
    if row.key:
        return f"set {row.key} of this drive in the rig file to what its manual allows"
    if row.role == "safety":
        return row.waiver
    return "check what the drive supports"
