"""Sentences printed about a fit."""

import numpy as np

from ident.dynamics import mechanisms
from ident.dynamics.effects.base import INFINITE_TIME
from ident.dynamics.effects.library import load
from ident.dynamics.structure import ModelStructure, Term
from ident.output.console.fit import shape_parameter_lines
from recordings.rig import simulated_rig


def test_shape_parameters_are_listed_and_infinite_times_are_never() -> None:
    rig = simulated_rig()
    term = Term("payload_change", load("payload_change"), (0, 1, 2))
    composition = ModelStructure(mechanisms.create(rig), rig, (term,))
    x = np.concatenate([np.ones(12), [7.25, INFINITE_TIME, 0.05]])
    (line,) = shape_parameter_lines(composition, x)
    assert line.endswith("payload_change.t_c = 7.25 s, payload_change.t_e never, payload_change.t_r = 0.05 s.")
    bare = ModelStructure(mechanisms.create(rig), rig)
    assert not [*shape_parameter_lines(bare, np.ones(11))]
