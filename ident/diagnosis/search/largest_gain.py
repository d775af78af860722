"""The most that an effect could explain on held-out rows: that of the coefficients which are best there."""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import block_counts
from ident.diagnosis.search.screening import MIN_EXCITATION, Candidate, Screener, initial_guesses
from ident.diagnosis.split.split_data import TINY
from ident.dynamics.structure import Term


class LargestGain:
    """The held-out rows of a model, weighted as the judge compares them."""

    def __init__(self, model: FittedModel) -> None:
        split, floor = model.split.turned, np.maximum(model.noise_floor.certain, TINY)
        rows = tuple(
            held_out & np.isfinite(residual)
            for held_out, residual in zip(split.train, model.judged_residuals, strict=True)
        )
        counts = block_counts(split, rows)
        self._blocks = sum(int((count > 0).sum()) for _, count in counts)
        weights = tuple(
            selected / floor / np.sqrt(np.maximum(count[block], 1.0))[:, None]
            for selected, (block, count) in zip(rows, counts, strict=True)
        )
        self._rig = model.solution.structure.rig
        split = replace(split, train=rows, weights=weights)
        self._screener = Screener(split, split.at(model.solution.structure, model.solution.x))
        self._rest = self._screener.orthogonal(self._screener.residual[:, None])[:, 0]

    def of(self, candidate: Candidate) -> float:
        """Upper bound, 0 to 1, of the share of the excess above the noise floor that the `candidate` could explain.

        It holds on whichever joints, and for every sum of the effect at the shapes of the `candidate` and at those
        that its effect declares: for the shapes between them, too, as far as their columns are such sums.
        """
        everywhere = Term.on_all_joints(candidate.term.name, candidate.term.effect, self._rig)
        declared = [(everywhere, *guess) for guess in initial_guesses(everywhere, suggestions=())]
        tried = [(candidate.term, candidate.scale, candidate.shapes), *declared]
        columns = np.hstack([self._screener.columns(*each) for each in tried])
        size = np.sqrt((columns**2).sum(axis=0))
        outside = self._screener.orthogonal(columns / np.maximum(size, TINY))
        along = outside.T @ self._rest
        explained = float(along @ np.linalg.pinv(outside.T @ outside, MIN_EXCITATION**2, hermitian=True) @ along)
        refitted = self._screener.loss - float(self._rest @ self._rest)  # beside it, the model fits other values
        return float(np.clip((refitted + explained) / max(self._screener.loss - self._blocks, TINY), 0.0, 1.0))
