"""The most that an effect could explain on held-out rows: that of the coefficients which are best there."""

from dataclasses import replace

import numpy as np

from ident.basics.statistics import least_squares, nonzero
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.paying_joints import own_joints
from ident.diagnosis.search.screening import MIN_EXCITATION, Candidate, Screener, initial_guesses
from ident.diagnosis.split.split_data import TINY
from ident.dynamics.structure import Term
from recordings.recording import Bools, Floats, Ints


class LargestGain:
    """The held-out rows of a model, weighted as the judge compares them: each joint by its own excess."""

    def __init__(self, model: FittedModel) -> None:
        blocks, turned = model.blocks_over(model), model.split.turned
        self._structure, solution = model.solution.structure, model.solution
        rows = tuple(
            held_out & np.isfinite(residual)
            for held_out, residual in zip(turned.train, model.judged_residuals, strict=True)
        )
        weights = tuple(selected / np.sqrt(blocks.scale) for selected in rows)
        turned = replace(turned, train=rows, weights=weights)
        self._noise = blocks.count.sum(axis=0) * blocks.floor / blocks.scale
        self._fitted = Screener(model.split, solution)
        self._held_out = Screener(turned, turned.at(self._structure, solution.x))
        self._joint: Ints = np.concatenate([np.nonzero(rows[i])[1] for i in turned.train_indices])

    def of(self, candidate: Candidate) -> float:
        """Upper bound, 0 to 1, of the share of the excess above the noise floor that the `candidate` could explain.

        It is that of the joint of which it could explain most, or of all together where it does not act on joints
        alone. It holds for every sum of the effect at the shapes of the `candidate` and at those that its effect
        declares, beside the model as it is refitted: for the shapes between them, too, as far as their columns are
        such sums.
        """
        everywhere = Term.on_all_joints(candidate.term.name, candidate.term.effect, self._structure.rig)
        scales = self._fitted.guess_scales(everywhere)
        declared = [(everywhere, *guess) for guess in initial_guesses(everywhere, (), scales)]
        tried = [(candidate.term, candidate.scale, candidate.shapes), *declared]
        replaced = self._fitted.replaced(everywhere)
        columns, held_out = (
            np.hstack([*(each.columns(*guess) for guess in tried), each.regressor[:, replaced]])
            for each in (self._fitted, self._held_out)
        )
        kept = np.delete(np.arange(self._fitted.regressor.shape[1]), replaced)
        model = least_squares(self._fitted.regressor[:, kept], columns)
        held_out -= self._held_out.regressor[:, kept] @ model  # with the effect, the model's own parameters move
        if own_joints(candidate.term) is None:
            return self._share(held_out, np.ones(len(held_out), bool), float(self._noise.sum()))
        joints = [(self._joint == joint, float(noise)) for joint, noise in enumerate(self._noise)]
        return max(self._share(held_out, *each) for each in joints)

    def _share(self, columns: Floats, rows: Bools, noise: float) -> float:
        """Share of the excess of the `rows` (r,) that sums of the `columns` (r, c) explain."""
        columns, residual = columns[rows], self._held_out.residual[rows]
        excess = float(residual @ residual) - noise
        columns = columns / nonzero(np.sqrt((columns**2).sum(axis=0)))
        along = columns.T @ residual
        explained = float(along @ np.linalg.pinv(columns.T @ columns, MIN_EXCITATION**2, hermitian=True) @ along)
        return float(np.clip(explained / max(excess, TINY), 0.0, 1.0))
