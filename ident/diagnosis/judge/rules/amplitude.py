"""Amplitudes that hardware usually has. More is not impossible: it has a price (`judge.price`)."""

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.rules.limits import possible_instances
from ident.dynamics.structure import Term
from recordings.recording import Floats


def plausible_instances(term: Term, local: Floats) -> list[bool]:
    """For each instance of `term`, whether its parameters `local` (instances, c) are possible and plausibly small."""
    sizes, limit = np.linalg.norm(local, axis=1), _limit(term)
    pairs = zip(possible_instances(term, local), sizes, strict=True)
    return [possible and bool(size <= limit) for possible, size in pairs]


def extraordinary_joints(model: FittedModel, index: int) -> list[int]:
    """Joints (from 0) on which the effect `index` of `model` is larger than hardware usually has."""
    term, sizes = model.terms[index], _amplitudes(model, index)
    joints = term.joints if len(sizes) == len(term.joints) else term.joints[:1]
    return [joint for joint, size in zip(joints, sizes, strict=True) if size > _limit(term)]


def _amplitudes(model: FittedModel, index: int) -> list[float]:
    """Amplitude of each instance of the term `index`."""
    local = model.solution.structure.local_values(index, model.solution.x)
    return [float(np.linalg.norm(row)) for row in local]


def _limit(term: Term) -> float:
    """Largest plausible amplitude of `term`."""
    limit = term.effect.max_amplitude
    return np.inf if limit is None else limit
