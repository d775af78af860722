"""Payload that is picked up or lost during the run."""

from typing import Any

import numpy as np

from ident.dynamics.effect_inputs import EffectInputs
from ident.dynamics.effects.base import INFINITE_TIME, Additive, Quantity
from recordings.recording import Floats, Ints

_COARSE = 100
"""Number of instants in the coarse grid of beginnings and ends."""
_ITERATIONS = 3
"""Number of alternating refinements of beginning and end, each among all instants."""
_MIN_SHARE = 0.01
"""Smallest share of the run with the payload, and without it."""
_TRANSITION = 0.02
"""Initial guess of the transition time [s]."""
_TINY = 1e-30


def torque(t: Any, dt: Any, torque_per_mass: Any, t_c: Any, t_e: Any, t_r: Any) -> Any:
    """That of 1 kg at the platform or tool while it is there."""
    # At least one sample long, so that the derivative by the instants does not vanish.
    length = np.hypot(t_r, dt)
    since, until = (np.minimum(np.maximum((t - at) / length + 0.5, 0.0), 1.0) for at in (t_c, t_e))
    return (since - until) * torque_per_mass


def suggest(inputs: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """Suggest the step and the interval of added mass that explain most of the `residual` (n, dof)."""
    per_mass = inputs.torque_per_mass
    known = np.isfinite(residual) & np.isfinite(per_mass)
    # Cumulative sums up to each instant (n + 1,).
    product, square = (
        np.concatenate([[0.0], np.where(known, signal, 0.0).sum(axis=1).cumsum()])
        for signal in (residual * per_mass, per_mass**2)
    )
    end = len(inputs.time)
    instants = np.arange(end + 1)
    step = int(np.argmax(_cost_reductions(product, square, instants, end)))
    coarse = np.unique(np.linspace(0, end, _COARSE).astype(int))
    first, second = (coarse[i] for i in np.triu_indices(len(coarse), 1))
    best = np.argmax(_cost_reductions(product, square, first, second))
    start, stop = int(first[best]), int(second[best])
    for _ in range(_ITERATIONS):
        start = int(np.argmax(_cost_reductions(product, square, instants[: stop + 1], stop)))
        stop = start + int(np.argmax(_cost_reductions(product, square, start, instants[start:])))
    inside = _MIN_SHARE * square[-1] < square[start] and square[stop] < (1 - _MIN_SHARE) * square[-1]
    intervals = [(step, end), (start, stop)] if inside else [(step, end)]
    half = 0.5 / inputs.rate  # the change happened between this instant and the one before
    return [
        {
            "t_c": float(inputs.time[i]) - half,
            "t_e": float(inputs.time[j]) - half if j < end else INFINITE_TIME,
            "t_r": _TRANSITION,
        }
        for i, j in intervals
        if i < end
    ]


def _cost_reductions(product: Floats, square: Floats, first: Ints | int, second: Ints | int) -> Floats:
    """Reduction of the sum of squares by a mass from `first` to `second`, beyond that by a constant mass."""
    share = (square[second] - square[first]) / max(square[-1], _TINY)
    excess = product[second] - product[first] - share * product[-1]
    return excess**2 / np.maximum(square[-1] * share * (1 - share), _MIN_SHARE * square[-1] + _TINY)


effect = Additive(
    sentence="Platform or tool becomes heavier or lighter at some moment of the run.",
    size="{dm}, at {t_c}",
    symptom="From one moment on, the residual follows the weight and inertia of a mass at the platform or tool.",
    causes="a gripper that picks something up or loses it, a part that came loose",
    remedy="record with the load fixed; tell the controller when the load changes",
    record="a run long enough to hold the motion with and without the mass, repeated in cycles",
    equation="J' dm (P'' - g) from t_c to t_e, coming and going within t_r",
    axis="time",
    mechanisms=("delta", "urdf"),
    whole_robot=True,
    formula=torque,
    parameters=(Quantity(name="dm", unit="kg", meaning="mass that is added"),),
    shapes=(
        Quantity(name="t_c", unit="s", meaning="when it is added", lower=0.0, upper=INFINITE_TIME),
        Quantity(name="t_e", unit="s", meaning="when it is taken off again", upper=INFINITE_TIME, searched=False),
        Quantity(name="t_r", unit="s", meaning="how long it takes until it is all there", lower=1e-3, upper=0.5),
    ),
    suggest=suggest,
    on_arm=True,
)
