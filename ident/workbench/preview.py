"""Preview of each candidate: the part of the residual that it would explain, and a figure of it."""

from collections.abc import Mapping

import numpy as np

from ident.diagnosis.effect_contribution import EffectContribution
from ident.diagnosis.noise_floor import NoiseFloor
from ident.diagnosis.screening import Candidate
from ident.diagnosis.split_data import SplitData
from ident.diagnosis.steps import FittedModel
from ident.output.figures.finding import effect_contribution
from ident.workbench import plots
from ident.workbench.views import CandidatePreviews


def candidate_previews(
    split: SplitData, model: FittedModel, candidates: Mapping[str, Candidate], floor: NoiseFloor
) -> CandidatePreviews:
    """Compute the previews of all `candidates` for `model`."""
    estimator = EffectContribution(split, model.solution)
    contributions, figures = {}, {}
    for name, candidate in candidates.items():
        torques = estimator.compute(candidate)
        contributions[name] = tuple(torque.astype(np.float32) for torque in torques)
        figures[name] = plots.to_dict(effect_contribution(model, candidate.term, torques, floor.rms))
    return CandidatePreviews(contributions, figures)
