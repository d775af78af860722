"""Torque without weight, beside the effects that were found, where no mass is known that could refute it."""

from dataclasses import replace

import numpy as np

from ident.data.prepared_recording import PreparedRecording, prepare
from ident.diagnosis.judge.fitted_model import FittedModel
from ident.diagnosis.judge.price import is_preferred, slack
from ident.diagnosis.search.selection import Finding, Selection
from ident.diagnosis.split.split_data import SplitData
from ident.dynamics.structure import ModelStructure
from ident.estimation.predicted_torque import TorquePredictor

KIND = "gravity-missing"
"""The data problem of this name: a drive that has taken gravity out of what it reports."""


def compare_without_weight(selection: Selection) -> tuple[Selection, bool]:
    """The `selection` with missing weight as an alternative to each effect that it explains as well.

    And whether the last model is much better without weight: what an effect cannot explain, this does.
    """
    split, first = selection.model.split, selection.model.split.recordings[0]
    if first.recording.rig.mechanism != "urdf" or first.nominal is not None:
        return selection, False
    floating = tuple(TorquePredictor(_weightless(each)) for each in split.recordings)
    weightless = replace(split, predictors=floating)
    findings = tuple(
        replace(finding, alternatives=(*finding.alternatives, KIND)) if _explains(weightless, finding) else finding
        for finding in selection.findings
    )
    return replace(selection, findings=findings), is_preferred(_fitted(weightless, selection.model), selection.model)


def _weightless(prepared: PreparedRecording) -> PreparedRecording:
    """The same recording of a robot in free fall."""
    recording = prepared.recording
    floating = replace(recording, rig=recording.rig.model_copy(update={"gravity": (0.0, 0.0, 0.0)}))
    return prepare(floating, prepared.method, prepared.cutoff, prepared.start, prepared.end)


def _fitted(weightless: SplitData, model: FittedModel) -> FittedModel:
    """The effects of `model` beside the mechanism without weight."""
    mechanism, rig = weightless.recordings[0].mechanism, weightless.recordings[0].recording.rig
    of_effects = model.solution.x[len(model.split.recordings[0].mechanism.parameters) :]
    start = np.concatenate([np.zeros(len(mechanism.parameters)), of_effects])
    return FittedModel(weightless, weightless.fit(ModelStructure(mechanism, rig, model.terms), start))


def _explains(weightless: SplitData, finding: Finding) -> bool:
    """Whether a model without weight and without the effect explains as much as the one with both."""
    rival = _fitted(weightless, finding.before)
    before, best = finding.before.solution.loss, min(finding.after.solution.loss, rival.solution.loss)
    as_good = rival.solution.loss <= best + slack(before, best, weightless.independent_rows)
    return as_good and not is_preferred(finding.after, rival)
