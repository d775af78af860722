"""Values that a drive will refuse, by its EDS or DCF: limits cannot be read from the drive itself."""

from pathlib import Path

from drivers.canopen.sdo import SdoWrite
from drivers.eds import load_dictionary
from recordings.rig import Drive


def refusal(drive: Drive, write: SdoWrite) -> str | None:
    """Why the drive will refuse a value, by the file in `eds` or `dcf`; None: nothing speaks against it there.

    Raises:
        BadInput: the file cannot be read.
    """
    file = drive.eds or drive.dcf
    if file is None:
        return None
    description = load_dictionary(Path(file), drive.node_id).get((write.index, write.sub))
    if description is None:
        return None
    if not description.is_writable:
        return f"{Path(file).name}: read only ({description.access})"
    low, high = description.low, description.high
    if (low is None or write.value >= low) and (high is None or write.value <= high):
        return None
    span = f"{'...' if low is None else low} to {'...' if high is None else high}"
    return f"{Path(file).name}: {span} allowed"
