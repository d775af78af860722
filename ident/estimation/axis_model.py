"""Model of one axis fitted to its frequency response: inertia, delay, and a resonance where there is one.

Rigid: position / torque = exp(-s d) / (J s^2 + c s + k). Elastic: the same, times (1 + 2 z_a s / w_a + s^2 / w_a^2)
over (1 + 2 z_r s / w_r + s^2 / w_r^2): the antiresonance w_a, at which the load holds the motor, below the resonance
w_r of motor against load. A delay turns the phase in proportion to the frequency, a resonance back and forth.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.optimize import least_squares

from ident.data.frequency_response import Complex, FrequencyResponse
from recordings.errors import BadInput
from recordings.recording import Floats

_LOWEST = 4.0
"""Frequency [Hz] below which friction and gravity outweigh inertia."""
_LARGEST_DEVIATION = 0.4
"""Relative standard deviation above which a line is not used."""
_LEAST_DEVIATION = 0.03
"""Relative standard deviation that every line has at least: friction is not linear."""
_MIN_LINES = 12
_FEWER = 0.5
"""Share of the rigid model's misfit below which an elastic model explains more than its four further parameters."""
_MOST_DAMPED = 0.7
"""Damping ratio from which on there is no resonance."""

_DELAYS = (0.0, 0.004)
"""Initial guesses of the delay [s]: phases repeat after a turn."""

_RATIO = 1.8
"""Initial guess of resonance over antiresonance."""

_Model = Callable[[Floats, Floats], Complex]


@dataclass(frozen=True)
class AxisModel:
    """Parameters of the model; those of the resonance are None for a rigid axis."""

    inertia: float
    """At low frequency [kg m^2]."""
    viscous: float
    """Friction of the small motion, in N m s/rad."""
    delay: float
    """From the reported voltage or torque to the motion [s]."""
    antiresonance: float | None
    """[Hz]."""
    resonance: float | None
    """[Hz]."""
    lines: int
    """Number of frequencies that were used."""
    highest: float
    """The highest of them [Hz]."""
    misfit: float
    """Root mean square of the relative deviations from the response."""
    response: Callable[[Floats], Complex]
    """Position over torque at frequencies [Hz]."""


def fit_axis(measured: FrequencyResponse) -> AxisModel:
    """Fit the rigid and the elastic model, and keep the elastic one only where it explains much more.

    Raises:
        BadInput: too few lines stand out of noise and friction.
    """
    used = (measured.motion_deviation < _LARGEST_DEVIATION) & (measured.frequency >= _LOWEST)
    if np.count_nonzero(used) < _MIN_LINES:
        raise BadInput(
            f"{_MIN_LINES} or more lines above noise and friction expected, {np.count_nonzero(used)} found; record "
            "with a larger --amplitude"
        )
    omega, G = 2 * np.pi * measured.frequency[used], measured.motion[used]
    weight = 1 / np.maximum(measured.motion_deviation[used], _LEAST_DEVIATION)
    inertia = float(np.median(1 / (np.abs(G) * omega**2)))
    rigid, rigid_cost = _fit(
        _rigid, [np.array([np.log(inertia), 0, 0, delay]) for delay in _DELAYS], omega, G, weight
    )
    elastic, elastic_cost = _fit(_elastic, list(_initial_guesses(inertia, omega)), omega, G, weight)
    is_elastic = elastic_cost < _FEWER * rigid_cost and _is_resonance(elastic, omega)
    model, parameters = (_elastic, elastic) if is_elastic else (_rigid, rigid)
    antiresonance, resonance = _resonances(elastic) if is_elastic else (None, None)
    return AxisModel(
        inertia=float(np.exp(parameters[0])),
        viscous=float(np.exp(parameters[1])),
        delay=float(parameters[3]),
        antiresonance=antiresonance,
        resonance=resonance,
        lines=len(omega),
        highest=float(omega[-1] / (2 * np.pi)),
        misfit=float(np.sqrt(np.mean(np.abs(model(parameters, omega) / G - 1) ** 2))),
        response=lambda frequency: model(parameters, 2 * np.pi * frequency),
    )


def _rigid(p: Floats, omega: Floats) -> Complex:
    inertia, viscous = np.exp(p[:2])
    response: Complex = np.exp(-1j * omega * p[3]) / (-inertia * omega**2 + 1j * viscous * omega + p[2])
    return response


def _elastic(p: Floats, omega: Floats) -> Complex:
    antiresonance = np.exp(p[4])
    zeros = _second_order(omega / antiresonance, np.exp(p[6]))
    poles = _second_order(omega / (antiresonance * (1 + np.exp(p[5]))), np.exp(p[7]))
    response: Complex = _rigid(p, omega) * zeros / poles
    return response


def _second_order(ratio: Floats, damping: float) -> Complex:
    factor: Complex = 1 - ratio**2 + 2j * damping * ratio
    return factor


def _resonances(p: Floats) -> tuple[float, float]:
    antiresonance = float(np.exp(p[4]) / (2 * np.pi))
    return antiresonance, float(antiresonance * (1 + np.exp(p[5])))


def _is_resonance(p: Floats, omega: Floats) -> bool:
    antiresonance, resonance = _resonances(p)
    inside = omega[0] < 2 * np.pi * antiresonance and 2 * np.pi * resonance < omega[-1]
    return bool(inside and np.exp(p[6]) < _MOST_DAMPED and np.exp(p[7]) < _MOST_DAMPED)


def _initial_guesses(inertia: float, omega: Floats) -> Iterator[Floats]:
    for antiresonance, delay in product(np.geomspace(1.5 * omega[0], 0.7 * omega[-1], 5), _DELAYS):
        yield np.array([np.log(inertia), 0, 0, delay, np.log(antiresonance), np.log(_RATIO - 1), -3, -3])


def _fit(model: _Model, guesses: list[Floats], omega: Floats, G: Complex, weight: Floats) -> tuple[Floats, float]:
    """Least squares of the logarithmic deviations, from several initial guesses; parameters and cost."""

    def residuals(p: Floats) -> Floats:
        with np.errstate(all="ignore"):
            deviation = np.log(model(p, omega) / G)
        weighted = np.concatenate([deviation.real * weight, deviation.imag * weight])
        finite: Floats = np.nan_to_num(weighted, nan=1e6, posinf=1e6, neginf=-1e6)
        return finite

    fits = [least_squares(residuals, guess, loss="soft_l1", max_nfev=150) for guess in guesses]
    best = min(fits, key=lambda result: float(result.cost))
    return np.asarray(best.x), float(best.cost)
