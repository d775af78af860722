"""What each candidate would take away of the residual: its signature, made once, to be looked at in passing."""

from collections.abc import Mapping

import numpy as np

from ident.diagnosis.effect_contribution import Remover
from ident.diagnosis.noise_floor import Floor
from ident.diagnosis.screening import Candidate
from ident.diagnosis.split_data import Material
from ident.diagnosis.steps import State
from ident.output.figures.finding import signature
from ident.workbench import plots
from ident.workbench.views import Signatures


def foretaste(material: Material, state: State, candidates: Mapping[str, Candidate], floor: Floor) -> Signatures:
    """Of all `candidates` beyond the model `state`."""
    remover = Remover(material, state.solution)
    removed, figures = {}, {}
    for name, one in candidates.items():
        taken = remover.signature(one)
        removed[name] = tuple(part.astype(np.float32) for part in taken)
        figures[name] = plots.plain(signature(material, state, one.term, taken, floor.rms))
    return Signatures(removed, figures)
