"""TDMS (LabVIEW), by npTDMS: time is a channel, or follows from the step and start of a waveform."""

from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from recordings.importing.arrays import table_of_arrays
from recordings.importing.formats import library, reading
from recordings.importing.table import Table


def recognises(path: Path, head: bytes) -> bool:
    """See `ImportFormat`."""
    return head.startswith(b"TDSm")


def read(path: Path) -> Table:
    """See `ImportFormat`."""
    nptdms = library("nptdms", path, "TDMS", "tdms")
    with reading(path, "TDMS", "export it again"):
        groups = nptdms.TdmsFile.read(path).groups()
        channels = {
            f"{group.name}.{channel.name}" if len(groups) > 1 else channel.name: channel
            for group in groups
            for channel in group.channels()
        }
        arrays: dict[str, Any] = {name: channel[:] for name, channel in channels.items()}
        steps = [_waveform(channel) for channel in channels.values() if channel.properties.get("wf_increment")]
        units = {name: str(channel.properties.get("unit_string", "")) for name, channel in channels.items()}
        if not steps:
            return table_of_arrays(path, arrays, units)
        count, step, start = Counter(steps).most_common(1)[0][0]
        arrays.setdefault("time", np.arange(count) * step)
        return replace(table_of_arrays(path, arrays, {"time": "s", **units}), start=start)


def _waveform(channel: Any) -> tuple[int, float, str | None]:
    """Number of samples, step [s], and ISO 8601 time of the first sample, where it is there."""
    start = channel.properties.get("wf_start_time")
    text = None if start is None else f"{np.datetime_as_string(np.datetime64(start), unit='ms')}+00:00"
    return len(channel), float(channel.properties["wf_increment"]), text
