"""What a drive says of a fault for which it sent no EMCY."""

from drivers.canopen.axis import CanopenAxis
from drivers.canopen.sdo import format_address
from recordings.errors import RunFailed

_CODES = (((0x603F, 0), "<H"), ((0x1003, 1), "<I"))
"""Objects that hold the code of the last fault, with their standard types."""


def details(axis: CanopenAxis) -> str:
    """The code of the last fault by SDO, or by an EMCY that came late."""
    if axis.error_code:
        return f"{axis.name}: EMCY 0x{axis.error_code:04X} ({axis.error_text}) came later"
    try:
        for address, layout in _CODES:
            code = (axis.sdo.read_optional(*address, layout) or 0) & 0xFFFF
            if code:
                return f"{axis.name}: {format_address(*address)} says 0x{code:04X} ({axis.text_of(code)})"
    except RunFailed as error:
        return str(error)
    return f"{axis.name}: neither 603F:00 nor 1003:01 holds a code; read the display or the tool of the drive"
