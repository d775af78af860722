"""The most that an effect could explain on held-out rows: that of the coefficients which are best there."""

from dataclasses import replace

import numpy as np

from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.improvement import block_counts
from ident.diagnosis.search.screening import Candidate, Screener
from ident.diagnosis.split.split_data import TINY


class LargestGain:
    """The held-out rows of a model, weighted as the judge compares them."""

    def __init__(self, model: FittedModel) -> None:
        split, floor = model.split.turned, np.maximum(model.noise_floor.certain, TINY)
        judged = zip(split.train, model.judged_residuals, strict=True)
        rows = tuple(held_out & np.isfinite(residual) for held_out, residual in judged)
        counts = block_counts(split, rows)
        self._blocks = sum(int((count > 0).sum()) for _, count in counts)
        weights = tuple(
            selected / floor / np.sqrt(np.maximum(count[block], 1.0))[:, None]
            for selected, (block, count) in zip(rows, counts, strict=True)
        )
        split = replace(split, train=rows, weights=weights)
        self._screener = Screener(split, split.at(model.solution.structure, model.solution.x))
        self._rest = self._screener.orthogonal(self._screener.residual[:, None])[:, 0]

    def of(self, candidate: Candidate) -> float:
        """Upper bound, 0 to 1, of the share of the excess above the noise floor that the `candidate` could explain.

        It holds exactly for effects that are linear in their parameters at the shapes of the `candidate`.
        """
        columns = self._screener.columns(candidate.term, candidate.scale, candidate.shapes)
        basis = np.linalg.qr(self._screener.orthogonal(columns))[0]
        left = self._rest - basis @ (basis.T @ self._rest)
        excess = self._screener.loss - self._blocks
        reduction = self._screener.loss - float(left @ left)
        return float(np.clip(reduction / max(excess, TINY), 0.0, 1.0))
