"""Screen pairs of effects that show only together, by linear algebra alone.

Two effects may nearly cancel: a dead band makes small commands too weak, and a wrong exponent of the torque map may
make them too strong. Neither leaves less by itself, so that no selection of one effect after the other finds them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations, pairwise

import numpy as np

from ident.diagnosis.search.screening import Candidate, Screener, one_signed
from recordings.recording import Floats


@dataclass(frozen=True, eq=False)
class CandidatePair:
    """Two effects beside each other."""

    effects: tuple[Candidate, Candidate]
    """With initial guesses by linear extrapolation."""
    loss: float
    """Expected weighted sum of squares with both."""


def screen_pairs(screener: Screener, candidates: Sequence[Candidate]) -> list[CandidatePair]:
    """All pairs of `candidates` with different names and possible signs, the most promising first."""
    if not candidates:
        return []
    blocks = [screener.orthogonal(screener.columns(each.term, each.scale, each.shapes)) for each in candidates]
    columns = np.concatenate(blocks, axis=1)
    gram, correlation = columns.T @ columns, columns.T @ screener.residual
    ends = np.cumsum([0, *(block.shape[1] for block in blocks)])
    entries = [np.arange(first, end) for first, end in pairwise(ends)]
    pairs = []
    for i, j in combinations(range(len(candidates)), 2):
        first, second = candidates[i], candidates[j]
        if first.term.name == second.term.name:
            continue
        both = np.concatenate([entries[i], entries[j]])
        coefficients = np.linalg.lstsq(gram[np.ix_(both, both)], correlation[both], rcond=1e-9)[0]
        signs = np.concatenate([_signs(first), _signs(second)])
        if (coefficients * signs >= 0).all():
            loss = screener.loss - float(coefficients @ correlation[both])
            parts = np.split(coefficients, [len(entries[i])])
            pairs.append(CandidatePair((_with(first, parts[0]), _with(second, parts[1])), loss))
    return sorted(pairs, key=lambda pair: pair.loss)


def _signs(candidate: Candidate) -> Floats:
    """1 where only a positive coefficient is possible, -1 where only a negative one is, else 0."""
    return np.tile(one_signed(candidate.term), candidate.term.instances)


def _with(candidate: Candidate, coefficients: Floats) -> Candidate:
    """The `candidate` with other `coefficients` as its only initial guess."""
    other = replace(candidate, coefficients=coefficients)
    return replace(other, initial_guesses=(np.concatenate([other.local_values.ravel(), candidate.shapes]),))
