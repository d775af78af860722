"""The end of a run: every drive loses power by SDO, whatever the others answer."""

from collections.abc import Sequence

from drivers import cia402
from drivers.canopen import setup
from drivers.canopen.axis import CanopenAxis
from drivers.protocol import Report
from recordings.errors import RunFailed


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


def report_repeated_warnings(axes: Sequence[CanopenAxis], report: Report) -> None:
    """Report how often each warning came: during the run only its first coming was."""
    for axis in axes:
        for code, count in axis.warnings.items():
            if count > 1:
                report("info", axis.name, f"EMCY 0x{code:04X} ({axis.text_of(code)}) came {count} times")
