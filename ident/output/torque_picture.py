"""Picture of the torque by its causes: stacked over time, and the RMS of each beside it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ident.output.pictures import figure
from recordings.recording import Floats
from web.palette import CATEGORIES, JOINTS, NOISE

LONGEST = 4.0
"""Duration of the part that is drawn over time [s]."""
_COLOURS = (*JOINTS, NOISE, *CATEGORIES)


def draw(
    path: Path,
    title: str,
    time: Floats,
    torque: Floats,
    terms: Mapping[str, Floats],
    rms: Mapping[str, Floats],
    widths: Mapping[str, Floats] | None,
    units: Sequence[str],
) -> None:
    """Draw one row for each joint; what is positive is stacked upwards, what is negative downwards.

    time: (n,) [s]; torque and terms: (n, dof); rms: (dof,) of each cause; widths: relative half of its interval.
    """
    dof, names = torque.shape[1], list(terms)
    colours = [_COLOURS[k % len(_COLOURS)] for k in range(len(names))]
    with figure(path, title, 12.0, 1.8 + 2.4 * dof) as canvas:
        grid = canvas.subplots(dof, 2, sharex="col", squeeze=False, width_ratios=[3, 1])
        for joint, (over_time, shares) in enumerate(grid):
            parts = np.array([terms[name][:, joint] for name in names])
            for side in (np.maximum, np.minimum):
                over_time.stackplot(time, side(parts, 0.0), colors=colours, alpha=0.85, lw=0)
            over_time.plot(time, torque[:, joint], color="black", lw=1.0, label="torque")
            over_time.margins(x=0)
            over_time.set_ylabel(f"joint {joint + 1} [{units[joint]}]")
            whole = [rms[name][joint] for name in names]
            errors = (
                None if widths is None else [np.nan_to_num(widths[name][joint]) * rms[name][joint] for name in names]
            )
            shares.barh(names, whole, xerr=errors, color=colours, alpha=0.85, error_kw={"lw": 1.2})
            shares.invert_yaxis()
            shares.grid(axis="y", visible=False)
        grid[-1, 0].set_xlabel("time [s]")
        interval = "" if widths is None else ", 95 % interval"
        grid[-1, 1].set_xlabel(f"RMS [{units[-1]}]{interval}")
        grid[0, 0].legend(loc="upper right", frameon=False)
