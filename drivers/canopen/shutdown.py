"""The end of a run: every drive loses power by SDO, whatever the others answer, and says what has happened."""

from collections.abc import Sequence

from drivers import cia402
from drivers.canopen import setup
from drivers.canopen.axis import CanopenAxis
from drivers.canopen.sdo import format_address
from drivers.protocol import Report
from recordings.errors import RunFailed

_FAULT_CODES = (((0x603F, 0), "<H"), ((0x1003, 1), "<I"))
"""Objects that hold the code of the last fault, with their standard types."""


def power_off(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Command a quick stop, then Disable voltage; drives that do not answer are reported."""
    for command in (cia402.Controlword.QUICK_STOP, cia402.Controlword.DISABLE_VOLTAGE):
        for axis in axes:
            try:
                axis.clear_torque_offset()
                axis.stop_by(command)
            except RunFailed as error:
                report("error", axis.name, f"while switching power off: {error}")


def release(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Command Disable voltage again, and end the watch over this program's heartbeat."""
    for axis in axes:
        try:
            axis.command(cia402.Controlword.DISABLE_VOLTAGE)
            axis.clear_torque_offset()
            for write in setup.watchdog_off(axis.dictionary):
                axis.sdo.write(write)
        except RunFailed as error:
            report("error", axis.name, f"while closing: {error}")


def fault_details(axis: CanopenAxis) -> str:
    """What a drive says of a fault for which it sent no EMCY: its code by SDO, or by an EMCY that came late."""
    if axis.error_code:
        return f"{axis.name}: EMCY 0x{axis.error_code:04X} ({axis.text_of(axis.error_code)}) came later"
    try:
        for address, layout in _FAULT_CODES:
            code = (axis.sdo.read_optional(*address, layout) or 0) & 0xFFFF
            if code:
                return f"{axis.name}: {format_address(*address)} says 0x{code:04X} ({axis.text_of(code)})"
    except RunFailed as error:
        return str(error)
    return f"{axis.name}: neither 603F:00 nor 1003:01 holds a code; read the display or the tool of the drive"
