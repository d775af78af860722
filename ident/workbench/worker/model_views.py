"""Views of the current model: its torque, what each candidate effect would remove, and its residual."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from ident.basics.statistics import nonzero
from ident.diagnosis.document.result import model_file
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.search.screening import Candidate, effect_columns
from ident.diagnosis.split.split_data import SplitData
from ident.diagnosis.unknown.residual_test import UnexplainedResidual, estimate_unexplained
from ident.estimation.nonlinear_fit import Solution
from ident.identification.model import Model
from ident.identification.prediction import Prediction
from ident.output.figures import residuals, spectrum, theme, torque
from ident.output.figures.finding import effect_contribution
from ident.output.report.sections import causes
from ident.output.tables import residuals as tables
from ident.residuals import analysis
from ident.residuals.phases import phases
from ident.residuals.time_span import TorqueSeries
from ident.workbench.figure import to_dict
from ident.workbench.worker.views import CandidatePreviews, ResidualView
from recordings.recording import Floats

_MIN_SINGULAR_VALUE = 1e-12
"""Singular values of the model's derivatives below this share of the largest count as zero."""


def torque_series(model: FittedModel, before: FittedModel | None) -> tuple[TorqueSeries, ...]:
    """Return measured and computed torque of every recording, with the torque of the model `before`."""
    split, residuals = model.split, model.residuals
    earlier = before.residuals if before else (None,) * len(residuals)
    return tuple(
        TorqueSeries(
            name=data.recording.path.name,
            held_out=bool(test.any()) and not train.any(),
            time=data.time,
            measured=data.torque,
            computed=data.torque - residual,
            velocity=data.motion.velocity,
            position=data.motion.position,
            phase=phases(data),
            cycle=data.repeat + 1,
            scored=train | test,
            previous=None if previous is None else data.torque - previous,
        )
        for data, residual, previous, train, test in zip(
            split.recordings, residuals, earlier, split.train, split.test, strict=True
        )
    )


def candidate_previews(model: FittedModel, candidates: Mapping[str, Candidate]) -> CandidatePreviews:
    """Compute the part of the residual of `model` that each candidate would explain, and draw it."""
    noise_rms = model.noise_floor.rms.tolist()
    contributions, figures = {}, {}
    removed = removed_torques(model.split, model.solution, candidates.values())
    for (name, candidate), torques in zip(candidates.items(), removed, strict=True):
        beyond = model.split.beyond(candidate.term)
        torques = tuple(np.where(rows, np.nan, torque) for rows, torque in zip(beyond, torques, strict=True))
        contributions[name] = tuple(torque.astype(np.float32) for torque in torques)
        figures[name] = to_dict(effect_contribution(model, candidate.term, torques, noise_rms))
    return CandidatePreviews(contributions, figures)


def removed_torques(
    split: SplitData, solution: Solution, candidates: Iterable[Candidate]
) -> Iterator[tuple[Floats, ...]]:
    """Yield the (m, dof) torque that each candidate removes from the residual of each recording [N m].

    It follows the linearization used in `screening`: the candidate's columns times the coefficients estimated from
    the training rows, while all parameters of the model adapt linearly. NaN where unknown.
    """
    linear = [predictor.linearized(solution.structure, solution.x) for predictor in split.predictors]
    regressor, _ = solution.rows()
    size = nonzero(np.sqrt((regressor**2).sum(axis=0)))
    inverse = np.linalg.pinv(regressor / size, rcond=_MIN_SINGULAR_VALUE) / size[:, None]
    for candidate in candidates:
        term, scale, shapes = candidate.term, candidate.scale, candidate.shapes
        torques = [
            effect_columns(predictor, solution, term, scale, shapes, computed) @ candidate.coefficients
            for predictor, (computed, _) in zip(split.predictors, linear, strict=True)
        ]
        pairs = zip(split.train_indices, solution.weights, strict=True)
        rows = np.concatenate([(weight * torques[i])[weight > 0] for i, weight in pairs])
        adjustment = inverse @ np.nan_to_num(rows)
        yield tuple(torque - slopes @ adjustment for torque, (_, slopes) in zip(torques, linear, strict=True))


def residual_view(
    model: FittedModel, diagnosed: bool, unexplained: UnexplainedResidual | None = None
) -> ResidualView:
    """Analyse the residual of `model` on the validation recording, or else on the training recording.

    It is the analysis of `ident compare`.

    diagnosed: whether the full diagnosis has found it; unexplained: what it has said of its residual above the noise
    floor; None: that is estimated.
    """
    file = model_file(model, unexplained or estimate_unexplained(model), diagnosed=diagnosed)
    split = model.split
    shown = [i for i, rows in enumerate(split.test) if rows.any() or not split.other_motion]
    predictions = [Prediction(split.recordings[i], model.computed[i], split.scored[i]) for i in shown]
    analysed = analysis.analyse(file, predictions, file.residual_test)
    models = {"model": analysed}
    figures = {
        "Residual by motion phase": residuals.phases(models),
        "Residual over the quantities that it depends on": residuals.curves(models),
        "Residual by frequency": spectrum.densities(models),
    }
    explained = [curve.explained for joint in analysed.joints for curve in joint.curves]
    tells_most = [analysed.windows[0].joint - 1 if analysed.windows else 0, int(np.argmax(explained))]
    for figure, first in zip(figures.values(), (*tells_most, tells_most[0]), strict=True):
        figure.update_layout(meta={theme.FIRST: first})
    if analysed.windows:
        figures["Worst intervals in detail"] = torque.worst_windows(analysed)
    effects = {term.name: term.effect for term in model.solution.structure.terms}
    text, plot, table = causes.torque_by_cause(Model(file, effects), predictions[0].prepared)
    return ResidualView(
        model=file,
        recordings=tuple(dict.fromkeys(item.prepared.recording.path.name for item in analysed.predictions)),
        sentences=analysed.sentences,
        windows=analysed.windows,
        window_table=tables.windows(analysed),
        figures={title: to_dict(figure) for title, figure in figures.items()},
        causes=replace(table, caption=f"{plot.caption} {table.caption}"),
        causes_sentences=text.lines,
        causes_figure=to_dict(plot.figure),
    )
