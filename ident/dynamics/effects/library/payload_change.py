"""A load that is picked up, or lost, during the run."""

import numpy as np

from ident.dynamics.effect_inputs import GRAVITY, EffectInputs
from ident.dynamics.effects.base import INFINITE_TIME, Additive, Quantity, Shapes
from recordings.recording import Floats, Ints

_COARSE = 100
"""Instants between which stretches are tried."""
_TURNS = 3
"""Times that its beginning and its end are then sought anew, each among all instants."""
_LEAST = 0.01
"""Share of the run that a change is taken to last at least, and to leave."""
_QUICK = 0.02
"""What a change is taken to last at first [s]."""
_TINY = 1e-30


def columns(view: EffectInputs, shapes: Shapes) -> Floats:
    """Torque that 1 kg at the platform takes while it is there (n, dof, 1)."""
    # Over an instant's time at least, so that a fit sees where the beginning should move to.
    length = np.hypot(shapes["t_r"], 1 / view.rate)
    since, until = (np.clip((view.time - shapes[name]) / length + 0.5, 0.0, 1.0) for name in ("t_c", "t_e"))
    torque: Floats = ((since - until)[:, None] * _per_mass(view))[:, :, None]
    return torque


def suggest(view: EffectInputs, residual: Floats) -> list[dict[str, float]]:
    """The instant from which on, and the stretch in which, a change of mass would explain most of the `residual`."""
    per_mass = _per_mass(view)
    known = np.isfinite(residual) & np.isfinite(per_mass)
    # Up to each instant (n + 1,): what a mass would explain together with the residual, and its own squares.
    gain, weight = (
        np.concatenate([[0.0], np.where(known, one, 0.0).sum(axis=1).cumsum()])
        for one in (residual * per_mass, per_mass**2)
    )
    end = len(view.time)
    every = np.arange(end + 1)
    for_good = int(np.argmax(_falls(gain, weight, every, end)))
    coarse = np.unique(np.linspace(0, end, _COARSE).astype(int))
    first, second = (coarse[i] for i in np.triu_indices(len(coarse), 1))
    best = np.argmax(_falls(gain, weight, first, second))
    start, stop = int(first[best]), int(second[best])
    for _ in range(_TURNS):
        start = int(np.argmax(_falls(gain, weight, every[: stop + 1], stop)))
        stop = start + int(np.argmax(_falls(gain, weight, start, every[start:])))
    inside = _LEAST * weight[-1] < weight[start] and weight[stop] < (1 - _LEAST) * weight[-1]
    found = [(for_good, end), (start, stop)] if inside else [(for_good, end)]
    half = 0.5 / view.rate  # what is there at an instant was added since the one before
    return [
        {
            "t_c": float(view.time[i]) - half,
            "t_e": float(view.time[j]) - half if j < end else INFINITE_TIME,
            "t_r": _QUICK,
        }
        for i, j in found
        if i < end
    ]


def _falls(gain: Floats, weight: Floats, first: Ints | int, second: Ints | int) -> Floats:
    """Fall of the sum of squares by a mass from `first` to `second`, beyond what a constant one explains."""
    share = (weight[second] - weight[first]) / max(weight[-1], _TINY)
    part = gain[second] - gain[first] - share * gain[-1]
    falls: Floats = part**2 / np.maximum(weight[-1] * share * (1 - share), _LEAST * weight[-1] + _TINY)
    return falls


def _per_mass(view: EffectInputs) -> Floats:
    """J' (P'' - g) (n, dof)."""
    lifted = view.platform.acceleration + np.array([0.0, 0.0, GRAVITY])
    torque: Floats = np.einsum("nij,ni->nj", view.platform.jacobian, lifted)
    return torque


effect = Additive(
    sentence="The platform becomes heavier or lighter at some moment of the run.",
    symptom="From one moment on, the residual follows the weight and inertia of a mass at the platform.",
    causes="a gripper that picks something up or loses it, a part that came loose",
    remedy="record with the load fixed; tell the controller when the load changes",
    equation="J' dm (P'' - g) from t_c to t_e, coming and going within t_r",
    axis="time",
    mechanisms=("delta",),
    whole_robot=True,
    coefficients=(Quantity(name="dm", unit="kg", meaning="mass that is added"),),
    shapes=(
        Quantity(name="t_c", unit="s", meaning="when it is added", lower=0.0, upper=INFINITE_TIME),
        Quantity(name="t_e", unit="s", meaning="when it is taken off again", upper=INFINITE_TIME, searched=False),
        Quantity(name="t_r", unit="s", meaning="how long it takes until it is all there", lower=1e-3, upper=0.5),
    ),
    suggest=suggest,
    columns=columns,
)
