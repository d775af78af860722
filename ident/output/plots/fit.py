"""Draw a fit: measured against computed torque (Figures 3 and 6), residual, convergence."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from ident.data.prepared_recording import PreparedRecording
from ident.estimation.lad_certificate import Certificate
from ident.identification.identify import Identification
from recordings.recording import Floats

# A missing font is replaced; the warning is of no use to the user.
logging.getLogger("matplotlib.font_manager").setLevel(logging.ERROR)

# Palette of Okabe and Ito, distinct for colour-blind readers.
MEASURED, COMPUTED, NOMINAL = "#000000", "#0072B2", "#E69F00"
STYLE: Any = {
    "font.size": 10,
    "axes.grid": True,
    "grid.alpha": 0.3,
    "axes.spines.top": False,
    "axes.spines.right": False,
}


def draw(result: Identification, folder: Path) -> None:
    """Draw torque and residual of every recording, named by its role, and the convergence into `folder`."""
    model = result.model
    roles = [(f"train_{i}", regression) for i, regression in enumerate(result.train, start=1)]
    if result.validation:
        roles.append(("validate", result.validation))
    for role, regression in roles:
        prepared, computed = regression.prepared, regression.predicted_torque(result.fit.parameters)
        title = f"{role.partition('_')[0]}: {prepared.recording.path.name}, {prepared.bandwidth:g} Hz bandwidth"
        if prepared.recording.run.simulated:
            title += ", SIMULATED"
        torque(folder / f"{role}_torque.png", title, prepared, computed)
        residual(folder / f"{role}_residual.png", title, prepared, computed)
    estimate = result.fit.estimate
    if len(estimate.history) > 1 and estimate.certificate:
        ended = f"{model.method.name}, seed {model.method.seed}: objective ended at {estimate.objective:.6g}"
        convergence(folder / "convergence.png", ended, estimate.history, estimate.certificate)


def torque(path: Path, title: str, prepared: PreparedRecording, computed: Floats) -> None:
    """Draw the first repetition: measured torque, the model's `computed` (m, dof) [N m], the manufacturer's model."""
    with _figure(path, title, prepared.torque.shape[1]) as axes:
        rows = prepared.first_cycle
        time, units = prepared.time[rows], prepared.recording.rig.effort_units
        for joint, axis in enumerate(axes):
            if prepared.nominal is not None:
                nominal = prepared.nominal[rows, joint]
                axis.plot(time, nominal, color=NOMINAL, lw=1.2, ls="--", label="Table 1 in Eq. (1)")
            axis.plot(time, prepared.torque[rows, joint], color=MEASURED, lw=3, alpha=0.35, label="measured")
            axis.plot(time, computed[rows, joint], color=COMPUTED, lw=1.2, label="fitted model")
            axis.margins(x=0)
            axis.set_ylabel(f"joint {joint + 1}\n{_effort_label(units[joint])}")
        axes[-1].set_xlabel("time [s]")
        axes[0].legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, frameon=False)


def residual(path: Path, title: str, prepared: PreparedRecording, computed: Floats) -> None:
    """Draw measured minus computed torque (m, dof) [N m] over the whole recording, with its RMS."""
    error = prepared.torque - computed
    limit = 1.1 * float(np.nanmax(np.abs(error)))
    units = prepared.recording.rig.effort_units
    with _figure(path, title, error.shape[1]) as axes:
        for joint, axis in enumerate(axes):
            rms = float(np.sqrt(np.nanmean(error[:, joint] ** 2)))
            axis.plot(prepared.time, error[:, joint], color=COMPUTED, lw=0.6)
            label = f"± RMS, {rms:.3g} {units[joint]}"
            axis.axhspan(-rms, rms, color=NOMINAL, alpha=0.35, lw=0, zorder=3, label=label)
            axis.set(ylim=(-limit, limit), ylabel=f"joint {joint + 1}\nresidual [{units[joint]}]")
            axis.margins(x=0)
            axis.legend(loc="lower right", bbox_to_anchor=(1, 0.97), frameon=False, borderpad=0)
        axes[-1].set_xlabel("time [s]")


def convergence(path: Path, title: str, history: Floats, certificate: Certificate) -> None:
    """Draw how the best objective fell towards its certified minimum."""
    with _figure(path, title, 1) as (axis,):
        excess = np.array([certificate.excess(value) for value in history])
        above = excess > 0
        axis.semilogy(np.flatnonzero(above), excess[above], color=COMPUTED, lw=1.6)
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
        canvas.savefig(path, dpi=110)


@contextmanager
def _figure(path: Path, title: str, rows: int) -> Iterator[list[Any]]:
    """Yield `rows` axes, one below the other, and save the figure at the end."""
    with figure(path, title, 10.0, 1.6 + 2.2 * rows) as canvas:
        yield list(canvas.subplots(rows, 1, sharex=True, squeeze=False)[:, 0])


def _effort_label(unit: str) -> str:
    return f"{'force' if unit == 'N' else 'torque'} [{unit}]"
