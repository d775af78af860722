"""Torque from which the drive has taken the weight, as some controllers report it: only against a known weight."""

from collections.abc import Sequence

import numpy as np
from scipy import stats

from ident.data.prepared_recording import PreparedRecording
from ident.data_problems.facts import Facts
from ident.dynamics.motion import Motion
from recordings.data_problems import DataProblem
from recordings.recording import Floats

_BLOCKS = 8
"""Spans of the recording, each of which tells the weight by itself."""
_CONFIDENCE = 0.95
_MAX_ERROR = 0.9
"""The known weight beside the measured torque leaves at most this share of the held-out error."""


def find(facts: Facts) -> DataProblem | None:
    """Return the problem if the torque holds no weight, the known weight is one, and with it the rows agree."""
    if any(each.nominal is None for each in facts.recordings):
        return None
    weight = [_weight(each) for each in facts.recordings]
    inertia, lift = _multiples(facts.recordings, weight)
    shares = lift[inertia > 0] / inertia[inertia > 0]
    if len(shares) < _BLOCKS // 2:
        return None
    low, high = stats.t.interval(_CONFIDENCE, len(shares) - 1, np.mean(shares), stats.sem(shares))
    if not low <= 0 <= high < 1:
        return None
    # The torque may be known up to a factor, which the inertia has, too.
    without, with_weight = _held_out(facts.recordings, [float(np.median(inertia)) * held for held in weight])
    if not with_weight < _MAX_ERROR * without:
        return None
    return DataProblem(
        kind="gravity-missing",
        joints=(),
        blocks=True,
        why=f"The torque holds {low:.0%} to {high:.0%} of the known weight; with all of it added, the held-out error "
        f"falls from {without:.3g} to {with_weight:.3g} N m: the drive has taken gravity out of what it reports.",
        remedy="Record the torque that the motor gives, such as its current times torque per ampere, in place of one "
        "from which the controller has taken gravity.",
    )


def _weight(each: PreparedRecording) -> Floats:
    """Torque (m, dof) that holds the known masses at rest."""
    still = np.zeros_like(each.motion.position)
    torque = each.mechanism.nominal_torque(Motion(each.motion.position, still, still, still))
    assert torque is not None
    return torque


def _multiples(recordings: Sequence[PreparedRecording], weight: Sequence[Floats]) -> tuple[Floats, Floats]:
    """How many times the known inertia, and the known weight, each span of the recordings holds beside friction."""
    found = []
    for each, held in zip(recordings, weight, strict=True):
        friction = [parameter.friction for parameter in each.mechanism.parameters]
        assert each.nominal is not None
        known = np.stack([each.nominal - held, held], axis=2)
        columns = np.concatenate([known, each.regressor[:, :, friction]], axis=2)
        spans = np.array_split(np.arange(len(held)), _BLOCKS)
        found += [_solved(columns[rows], each.torque[rows])[:2] for rows in spans]
    inertia, lift = np.array(found).T
    return inertia, lift


def _held_out(recordings: Sequence[PreparedRecording], weight: Sequence[Floats]) -> tuple[float, float]:
    """Error (RMS) on every second span, fitted on the others: of the measured torque, and with the weight added."""
    columns = np.concatenate([each.regressor for each in recordings])
    torque, held = np.concatenate([each.torque for each in recordings]), np.concatenate(list(weight))
    spans = np.arange(len(torque)) * 2 * _BLOCKS // len(torque) % 2 == 0
    errors = []
    for target in (torque, torque + held):
        left = target[~spans] - columns[~spans] @ _solved(columns[spans], target[spans])
        errors.append(float(np.sqrt(np.nanmean(left**2))))
    return errors[0], errors[1]


def _solved(columns: Floats, torque: Floats) -> Floats:
    """Least squares solution (k,) of the known rows."""
    known = np.isfinite(torque) & np.isfinite(columns).all(axis=2)
    return np.asarray(np.linalg.lstsq(columns[known], torque[known], rcond=None)[0], dtype=float)
