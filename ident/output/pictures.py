"""Pictures (PNG): the torque as in the paper and by its causes, and the convergence of a swarm."""

import logging
import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from delta_web.palette import CATEGORIES, CAUSES, JOINTS, MEASURED
from ident.data.prepared_recording import PreparedRecording
from ident.estimation.lad_certificate import Certificate
from ident.export.paths import TorquePath
from ident.export.torque_table import evaluate
from ident.identification.identify import Identification
from ident.identification.model import Model
from recordings.files import replacement
from recordings.recording import Floats

# A missing font is replaced; the warning is of no use to the user.
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)

OTHERS = (("black", "--"), (CATEGORIES[0], ":"), (CATEGORIES[1], "-."))
"""Colours and line styles of the models that the first one is compared with."""
LONGEST = 4.0
"""Duration of the part of a path that is drawn by causes [s]."""
STYLE: Any = {
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def draw(result: Identification, folder: Path) -> None:
    """Draw the torque in every recording, named by its role, and the convergence into `folder`."""
    roles = [(f"train_{i}", regression) for i, regression in enumerate(result.train, start=1)]
    roles += [(f"validate_{i}", regression) for i, regression in enumerate(result.validation, start=1)]
    for role, regression in roles:
        prepared, nominal = regression.prepared, regression.prepared.nominal
        curves = {"fitted model": regression.predicted_torque(result.fit.parameters)}
        if nominal is not None:
            curves["Table 1 in Eq. (1)"] = nominal
        title = f"{role.partition('_')[0]}, {prepared.bandwidth:g} Hz bandwidth"
        torque(folder / f"{role}_torque.png", title, prepared, [curves])
    estimate, method = result.fit.estimate, result.model.method
    if len(estimate.history) > 1 and estimate.certificate:
        ended = f"{method.name}, seed {method.seed}: objective ended at {estimate.objective:.6g}"
        convergence(folder / "convergence.png", ended, estimate.history, estimate.certificate)


def torque(path: Path, title: str, prepared: PreparedRecording, columns: Sequence[Mapping[str, Floats]]) -> None:
    """Draw the torque as `curves` does, beside sets of computed torques (m, dof) [N m]."""
    units = ["force [N]" if unit == "N" else "torque [N m]" for unit in prepared.recording.rig.effort_units]
    curves(path, title, prepared, prepared.torque, columns, units)


def curves(
    path: Path,
    title: str,
    prepared: PreparedRecording,
    measured: Floats,
    columns: Sequence[Mapping[str, Floats]],
    quantities: Sequence[str],
) -> None:
    """Draw the first repetition: one row for each joint, one column for each set of computed curves (m, dof).

    measured: (m, dof). quantities: name and unit for each joint.

    The first model of a set has the colour of the joint, as on every page.
    """
    recording, rows, dof = prepared.recording, prepared.first_cycle, measured.shape[1]
    title += f"\n{recording.path.name}{', SIMULATED' if recording.run.simulated else ''}"
    with figure(path, title, 10.0, 1.8 + 2.2 * dof) as canvas:
        axes = canvas.subplots(dof, len(columns), sharex=True, sharey="row", squeeze=False)
        for (joint, column), axis in np.ndenumerate(axes):
            time = prepared.time[rows]
            axis.plot(time, measured[rows, joint], color=MEASURED, lw=3, alpha=0.6, label="measured")
            styles = [(JOINTS[joint % len(JOINTS)], "-"), *OTHERS]
            for (colour, style), (name, computed) in zip(styles, columns[column].items(), strict=False):
                axis.plot(time, computed[rows, joint], color=colour, ls=style, lw=1.1, label=name)
            axis.margins(x=0)
            if column == 0:
                axis.set_ylabel(f"joint {joint + 1}\n{quantities[joint]}")
            if joint == 0:
                axis.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=5, frameon=False)
            if joint == dof - 1:
                axis.set_xlabel("time [s]")


def convergence(path: Path, title: str, history: Floats, certificate: Certificate) -> None:
    """Draw how the best objective fell towards its certified minimum."""
    with figure(path, title, 10.0, 3.8) as canvas:
        axis = canvas.subplots()
        excess = np.array([certificate.excess(value) for value in history])
        above = excess > 0
        axis.semilogy(np.flatnonzero(above), excess[above], color=CATEGORIES[0], lw=1.6)
        axis.set(xlabel="iteration", ylabel="objective above its\nminimum, relative")
        axis.set_xlim(0, len(history) - 1)


@contextmanager
def figure(path: Path, title: str, width: float, height: float) -> Iterator[Figure]:
    """Yield an empty figure in the common style, `width` by `height` inches, and save it at the end."""
    with mpl.rc_context(STYLE):
        canvas = Figure(figsize=(width, height), layout="constrained")
        FigureCanvasAgg(canvas)
        canvas.suptitle(title, fontsize=11)
        yield canvas
        canvas.savefig(path, dpi=110, format="png")


@contextmanager
def staged_folder(folder: Path) -> Iterator[Path]:
    """Yield a temporary folder to draw into; at the end, unless an error occurs, its pictures move to `folder`."""
    folder = folder.resolve()
    partial = folder.with_name(folder.name + ".part")
    try:
        partial.mkdir(parents=True, exist_ok=True)
        yield partial
        folder.mkdir(exist_ok=True)
        for picture in partial.iterdir():
            picture.replace(folder / picture.name)
    finally:
        shutil.rmtree(partial, ignore_errors=True)


def torque_by_cause(
    path: Path, model: Model, along: TorquePath, rms: Mapping[str, Floats], widths: Mapping[str, Floats] | None
) -> None:
    """Draw the torque by its causes in the middle of a path, stacked over time, and the RMS of each; all or nothing.

    One row for each joint; what is positive is stacked upwards, what is negative downwards.

    rms: (dof,) of each cause; widths: (dof,) relative half of its 95 % interval; None: not known.
    """
    chunk, units = along.excerpt(), model.file.effort_units
    whole, terms = evaluate(model, chunk)
    shown, names = slice(0, int(LONGEST * along.rate)), list(terms)
    time, colours = chunk.time[chunk.used][shown], [CAUSES[k % len(CAUSES)] for k in range(len(names))]
    height = 1.8 + 2.4 * len(units)
    with replacement(path) as partial, figure(partial, f"{along.name}: torque by cause", 12.0, height) as canvas:
        grid = canvas.subplots(len(units), 2, sharex="col", squeeze=False, width_ratios=[3, 1])
        for joint, (over_time, shares) in enumerate(grid):
            parts = np.array([terms[name][shown, joint] for name in names])
            for side in (np.maximum, np.minimum):
                over_time.stackplot(time, side(parts, 0.0), colors=colours, alpha=0.85, lw=0)
            over_time.plot(time, whole[shown, joint], color="black", lw=1.0, label="torque")
            over_time.margins(x=0)
            over_time.set_ylabel(f"joint {joint + 1} [{units[joint]}]")
            errors = (
                None if widths is None else [np.nan_to_num(widths[name][joint]) * rms[name][joint] for name in names]
            )
            lengths = [rms[name][joint] for name in names]
            shares.barh(names, lengths, xerr=errors, color=colours, alpha=0.85, error_kw={"lw": 1.2})
            shares.invert_yaxis()
            shares.grid(axis="y", visible=False)
        grid[-1, 0].set_xlabel("time [s]")
        grid[-1, 1].set_xlabel(f"RMS [{units[-1]}]{', 95 % interval' if widths else ''}")
        grid[0, 0].legend(loc="upper right", frameon=False)
