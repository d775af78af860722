"""Tables of recordings: machine, run, and quality of the data."""

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from ident.data.samples import holds_torque
from ident.output.tables import ResultTable
from recordings.recording import Recording

_WARNING_LEVELS = ("warning", "error", "fatal")


def facts(recording: Recording) -> dict[str, str]:
    """Return what is known of a recording before any fit, by label; what it does not hold is left out."""
    run, time, gaps, rig = recording.run, recording.time, recording.gaps, recording.rig
    length, lateness = rig.geometry, 1e3 * recording.lateness[np.isfinite(recording.lateness)]
    error = 1e3 * np.abs(recording.following_error)
    worst_error = np.nanmax(error, initial=0.0, where=np.isfinite(error))
    median, late, latest = np.percentile(lateness, (50, 99, 100)) if len(lateness) else (0.0, 0.0, 0.0)
    stated = {
        "Rig": f"{rig.name}: {rig.mechanism}, {rig.dof} joint{'s' if rig.dof > 1 else ''}",
        "Drives": run.drives_in_words,
        "Geometry": f"L1 {length.L1:g} m, L2 {length.L2:g} m ({length.L2_source}), R {length.R:g} m, r {length.r:g} m"
        if rig.mechanism == "delta"
        else "",
        "Torque gain": _gain(recording),
        "Motion": f"{run.trajectory}, {run.cycles} × {run.period:g} s" if run.period else run.trajectory,
        "Length": f"{time[-1] - time[0]:.2f} s, {len(time)} samples at {run.rate:g} Hz, "
        f"{'lockstep' if run.pace == 'lockstep' else 'real time'}",
        "Lost samples": ", ".join(f"joint {j}: {n}" for j, n in enumerate(gaps, 1) if n) or "none",
        "Lateness": f"median {median:.2f} ms, 99 % {late:.2f} ms, worst {latest:.2f} ms" if len(lateness) else "",
        "Following error": f"worst {worst_error:.2f} m{rig.position_units[0]}" if np.isfinite(error).any() else "",
        "Warnings and errors": str(sum(event.level in _WARNING_LEVELS for event in recording.events)),
        "Recorded": f"{run.start_in_words}, by {run.software}",
        "Ended": "INTERRUPTED" if run.exit_status is None else f"{run.reason} (exit status {run.exit_status})",
    }
    return {label: value for label, value in stated.items() if value}


def _gain(recording: Recording) -> str:
    torque = recording.rig.torque
    if holds_torque(recording):
        return f"torque was measured ({torque.gain_source})"
    relative = "assumed: torques are relative" if torque.gain_source == "assumed" else torque.gain_source
    law = "v |v|" if torque.map == "square" else "v"
    return f"{', '.join(f'{gain:g}' for gain in torque.gain)} times {law}, {relative}"


def side_by_side(recordings: Sequence[Recording], roles: Mapping[str, Sequence[str]]) -> ResultTable:
    """Return the facts of `recordings`, one column for each, below their `roles`: by label, one for each."""
    columns = [facts(recording) for recording in recordings]
    labels = dict.fromkeys(label for column in columns for label in column)
    rows = [(label, *cells) for label, cells in roles.items()]
    rows += [(label, *(column.get(label, "") for column in columns)) for label in labels]
    head = ("", *(recording.path.name for recording in recordings))
    return ResultTable(head, rows, words=range(len(head)))


def warnings(recording: Recording) -> Iterator[str]:
    """Yield what limits the use of a recording."""
    if not recording.complete:
        yield "The recording was interrupted; the data up to there are intact."
    elif recording.run.exit_status:
        yield f"The run did not end as planned: {recording.run.reason}"
    if recording.gaps.any():
        yield f"{int(recording.gaps.sum())} samples were lost; they are excluded, not interpolated."
    count = sum(event.level in _WARNING_LEVELS for event in recording.events)
    if count:
        yield f"{count} warnings and errors occurred while recording; see the events."
