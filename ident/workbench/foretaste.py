"""What each candidate would take away of the residual: its signature, made once, to be looked at in passing."""

from collections.abc import Mapping

import numpy as np

from ident.diagnose.floor import Floor
from ident.diagnose.material import Material
from ident.diagnose.removal import Remover
from ident.diagnose.rungs import State
from ident.diagnose.screen import Candidate
from ident.figures.finding import signature
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
