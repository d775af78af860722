"""The end of a run: every drive loses power by SDO, whatever the others answer."""

from collections.abc import Sequence

from drivers import cia402
from drivers.canopen import preparation, setup
from drivers.canopen.axis import CanopenAxis
from drivers.protocol import Report
from recordings.errors import RunFailed


def power_off(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Command a quick stop, then Disable voltage; drives that do not answer are reported."""
    for command in (cia402.Controlword.QUICK_STOP, cia402.Controlword.DISABLE_VOLTAGE):
        for axis in axes:
            try:
                _clear_torque_offset(axis)
                preparation.command_by_sdo(axis, command)
            except RunFailed as error:
                report("error", axis.name, f"while switching power off: {error}")


def release(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Command Disable voltage again, and end the watch over this program's heartbeat."""
    for axis in axes:
        try:
            axis.sdo.write(0x6040, 0, "<H", cia402.Controlword.DISABLE_VOLTAGE, check=False)
            _clear_torque_offset(axis)
            for write in setup.watchdog_off(axis.dictionary):
                axis.sdo.apply(write)
        except RunFailed as error:
            report("error", axis.name, f"while closing: {error}")


def report_repeated_warnings(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Report how often each warning came: during the run only its first coming was."""
    for axis in axes:
        for code, count in axis.warnings.items():
            if count > 1:
                report("info", axis.name, f"EMCY 0x{code:04X} ({axis.text_of(code)}) came {count} times")


def _clear_torque_offset(axis: CanopenAxis) -> None:
    if axis.drive.torque_offset:
        axis.sdo.write(0x60B2, 0, "<h", 0, check=False)
