"""A vibration beside ripple below the low-pass: at one speed, a wave over time is one over the angle."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import PreparedRecording
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import BLOCK_SECONDS, block_means, improvement_of_blocks
from ident.diagnosis.ripple.ripple import EFFECT
from ident.diagnosis.ripple.waves import remainder, wave, wave_numbers
from ident.diagnosis.search.selection import Finding, Selection
from ident.dynamics.effects.periodogram import periodogram
from recordings.recording import Bools, Floats

VIBRATION = "vibration"
"""Stands beside the names of effects; no effect of the library."""


def with_vibration_alternatives(selection: Selection) -> Selection:
    """The `selection` with a vibration as an alternative to each ripple that it explains as well."""
    findings = [
        replace(finding, alternatives=(*finding.alternatives, VIBRATION))
        if finding.term.name == EFFECT and not _differs(selection.model, finding)
        else finding
        for finding in selection.findings
    ]
    return replace(selection, findings=tuple(findings))


def _differs(model: FittedModel, finding: Finding) -> bool:
    """Whether the ripple explains more of any joint's residual without it than the best wave over time."""
    index = next(i for i, term in enumerate(model.terms) if term is finding.term)
    order = float(model.solution.structure.shape_values(index, model.solution.x)[0])
    recordings = list(zip(model.split.recordings, finding.before.residuals, model.split.scored, strict=True))
    for joint in finding.term.joints:
        over_time, over_angle = np.hstack([_mean_squares(*each, joint, order) for each in recordings])
        if improvement_of_blocks(over_time, over_angle).is_supported:
            return True
    return False


def _mean_squares(recording: PreparedRecording, residual: Floats, scored: Bools, joint: int, order: float) -> Floats:
    """(2, b) mean squares over blocks of what the best wave over time leaves of a `joint`, and that over the angle.

    residual, scored: (m, dof) [N m] and rows that count.
    """
    over_angle = recording.condition(wave(recording.preprocessed.motion.position[:, joint], order))
    residual = residual[:, joint]
    rows = scored[:, joint] & np.isfinite(residual) & np.isfinite(over_angle).all(axis=1)
    if not rows.any():
        return np.empty((2, 0))
    time, signal = recording.time[rows], residual[rows] - residual[rows].mean()
    block = np.floor(time / BLOCK_SECONDS).astype(int)
    waves = wave(time, _best(time, signal, recording.bandwidth)), over_angle[rows]
    return np.stack([block_means(block, remainder(columns, signal) ** 2) for columns in waves])


def _best(time: Floats, signal: Floats, bandwidth: float) -> float:
    """Angular frequency [rad/s] of the strongest wave over time within the bandwidth."""
    from scipy.optimize import minimize_scalar

    grid = wave_numbers(time, 2 * np.pi * bandwidth)
    if len(grid) < 2:
        return 0.0
    best, step = grid[periodogram(time, signal, grid).argmax()], grid[1] - grid[0]
    bounds = (best - step, best + step)
    return float(minimize_scalar(lambda omega: np.sum(remainder(wave(time, omega), signal) ** 2), bounds=bounds).x)
