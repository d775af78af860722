"""A vibration beside ripple below the low-pass: at one speed, a wave over time is one over the angle."""

from collections.abc import Sequence
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
        parts = [part for each in recordings if len((part := _rows(*each, joint, order))[0])]
        omega = _common_frequency(parts, model.split.recordings[0].bandwidth)
        over_time, over_angle = np.hstack([_mean_squares(omega, *part) for part in parts])
        if improvement_of_blocks(over_time, over_angle).is_supported:
            return True
    return False


def _rows(
    recording: PreparedRecording, residual: Floats, scored: Bools, joint: int, order: float
) -> tuple[Floats, Floats, Floats]:
    """Time (r,) [s], residual (r,) [N m] and wave over the angle (r, 2) of a `joint` in the rows that count.

    residual, scored: (m, dof) [N m] and rows that count.
    """
    over_angle = recording.condition(wave(recording.preprocessed.motion.position[:, joint], order))
    rows = scored[:, joint] & np.isfinite(residual[:, joint]) & np.isfinite(over_angle).all(axis=1)
    signal = residual[rows, joint]
    return recording.time[rows], signal - signal.mean() if rows.any() else signal, over_angle[rows]


def _mean_squares(omega: float, time: Floats, signal: Floats, over_angle: Floats) -> Floats:
    """(2, b) mean squares over blocks of what the wave over time leaves, and that over the angle."""
    block = np.floor(time / BLOCK_SECONDS).astype(int)
    return np.stack([block_means(block, remainder(each, signal) ** 2) for each in (wave(time, omega), over_angle)])


def _common_frequency(parts: Sequence[tuple[Floats, Floats, Floats]], bandwidth: float) -> float:
    """Angular frequency [rad/s] within the bandwidth of the strongest wave over time in all `parts`.

    A vibration keeps its frequency, whatever the speed of each recording.
    """
    from scipy.optimize import minimize_scalar

    grid = wave_numbers(np.concatenate([time for time, *_ in parts]), 2 * np.pi * bandwidth)
    if len(grid) < 2:
        return 0.0
    power = np.sum([periodogram(time, signal, grid) for time, signal, _ in parts], axis=0)
    best, step = grid[power.argmax()], grid[1] - grid[0]

    def left(omega: float) -> float:
        return float(sum(np.sum(remainder(wave(time, omega), signal) ** 2) for time, signal, _ in parts))

    return float(minimize_scalar(left, bounds=(best - step, best + step)).x)
