"""Friction that falls with the measured temperature."""

from typing import Any

from ident.dynamics.effects.base import Additive, Quantity
from ident.dynamics.effects.quantities import REFERENCE_TEMPERATURE


def friction(qd: Any, direction: Any, temperature: Any, c_v: Any, c_c: Any) -> Any:
    """Friction at the reference temperature times the warmth beyond it."""
    return (c_v * qd + c_c * direction) * (temperature - REFERENCE_TEMPERATURE)


effect = Additive(
    sentence="The joint rubs less the warmer its drive is.",
    size="{k:%} per degree",
    symptom="The residual opposes the motion, and falls as the measured temperature rises.",
    causes="grease and oil that get thinner with warmth, seals that soften, clearances that open",
    remedy="warm the machine up before recording; give the feed-forward the temperature",
    record="one motion from cold to warm, with the temperature of the drives recorded",
    equation="(c_v v + c_c sgn v) k (T - 25 degC), k <= 0",
    axis="velocity",
    needs=("temperature",),
    formula=friction,
    parameters=(
        Quantity(
            name="k", unit="1/K", meaning="relative change of friction per degree, of that at 25 degC", upper=0.0
        ),
    ),
)
