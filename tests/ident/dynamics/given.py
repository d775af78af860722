"""Inputs of effects, along a motion of the delta robot."""

from ident.data.prepared_recording import prepare
from ident.dynamics.effect_inputs import EffectInputs
from ident.estimation.predicted_torque import TorquePredictor
from tests.ident.conftest import TRUTH, make_recording


def effect_inputs(cycles: int, rate: float = 250.0, cutoff: float = 30.0) -> EffectInputs:
    """Inputs along fig5a, with the true parameters of the mechanism."""
    prepared = prepare(make_recording(cycles=cycles, rate=rate), "parallel", cutoff)
    return TorquePredictor(prepared).effect_inputs(prepared.base_structure, TRUTH)
