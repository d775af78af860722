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


def candidate_previews(material: SplitData, state: FittedModel, candidates: Mapping[str, Candidate], floor: NoiseFloor) -> CandidatePreviews:
    """Compute the previews of all `candidates` for the model `state`."""
    remover = EffectContribution(material, state.solution)
    removed, figures = {}, {}
    for name, one in candidates.items():
        taken = remover.compute(one)
        removed[name] = tuple(part.astype(np.float32) for part in taken)
        figures[name] = plots.to_dict(effect_contribution(material, state, one.term, taken, floor.rms))
    return CandidatePreviews(removed, figures)
