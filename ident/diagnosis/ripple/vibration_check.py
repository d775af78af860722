"""Check whether a vibration of fixed frequency explains as much as ripple over the angle that was found.

At a constant speed both are the same. A wave over the angle is certain only if the recordings contain speeds at which
it and every wave over time differ.
"""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import BLOCK_SECONDS, improvement_of_blocks
from ident.diagnosis.ripple.ripple import EFFECT
from ident.diagnosis.ripple.waves import least_squares, wave, wave_numbers
from ident.diagnosis.search.selection import Finding, Selection
from ident.dynamics.effects.periodogram import periodogram
from recordings.recording import Floats

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
    structure, x = model.solution.structure, model.solution.x
    index = next(i for i, term in enumerate(model.terms) if term is finding.term)
    order = float(structure.shape_values(index, x)[0])
    return any(_differs_on_joint(model, finding, order, joint) for joint in finding.term.joints)


def _differs_on_joint(model: FittedModel, finding: Finding, order: float, joint: int) -> bool:
    before: list[Floats] = []
    after: list[Floats] = []
    for number, recording in enumerate(model.split.recordings):
        residual = finding.before.residuals[number][:, joint]
        rows = model.split.scored[number][:, joint] & np.isfinite(residual)
        angle = recording.preprocessed.motion.position[:, joint]
        over_angle = recording.condition(np.where(np.isfinite(angle)[:, None], wave(angle, order), np.nan))
        rows &= np.isfinite(over_angle).all(axis=1)
        if not rows.any():
            continue
        time, signal = recording.time[rows], residual[rows] - residual[rows].mean()
        block = np.floor(time / BLOCK_SECONDS).astype(int)
        for columns, means in (
            (wave(time, _best(time, signal, recording.bandwidth)), before),
            (over_angle[rows], after),
        ):
            rest = signal - columns @ least_squares(columns, signal)
            count = np.bincount(block)
            means.append(np.bincount(block, rest**2)[count > 0] / count[count > 0])
    return bool(after) and improvement_of_blocks(np.concatenate(before), np.concatenate(after)).is_supported


def _best(time: Floats, signal: Floats, bandwidth: float) -> float:
    """Angular frequency [rad/s] of the strongest wave over time within the bandwidth."""
    from scipy.optimize import minimize_scalar

    grid = wave_numbers(time, 2 * np.pi * bandwidth)
    if len(grid) < 2:
        return 0.0
    best, step = grid[periodogram(time, signal, grid).argmax()], grid[1] - grid[0]
    bounds = (best - step, best + step)
    refined = minimize_scalar(lambda omega: _rest_square(wave(time, omega), signal), bounds=bounds, method="bounded")
    return float(refined.x)


def _rest_square(columns: Floats, signal: Floats) -> float:
    return float(np.sum((signal - columns @ least_squares(columns, signal)) ** 2))
