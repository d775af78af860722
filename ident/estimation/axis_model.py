"""Model of one axis fitted to its frequency response: inertia, delay, and a resonance where there is one.

Rigid: position / torque = exp(-s d) / (J s^2 + c s + k). Elastic: the same, times (1 + 2 z_a s / w_a + s^2 / w_a^2)
over (1 + 2 z_r s / w_r + s^2 / w_r^2): the antiresonance w_a, at which the load holds the motor, below the resonance
w_r of motor against load. A delay turns the phase in proportion to the frequency, a resonance back and forth.

The other motors give way to the torque of the coupling, so that the inertia appears smaller where their drives no
longer hold them; the phase of that change would be taken for a delay of 0.1 ms. Their measured positions y_j are
in the model: torque = position / G + sum_j m_j s^2 y_j / (1 + 2 z_a s / w_a + s^2 / w_a^2), as they act on the load.
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

_COUPLING = 0.3
"""Inertia of the coupling with another joint over that of the joint, as expected before the measurement; it is below
1 where both joints have the same inertia."""

_Model = Callable[[Floats, Floats, Complex], Complex]
"""Position over torque for parameters, angular frequencies (n,) and positions (n, others) of the other joints."""


@dataclass(frozen=True)
class AxisModel:
    """Parameters of the model; those of the resonance are None for a rigid axis."""

    inertia: float
    """At low frequency [kg m^2]."""
    viscous: float
    """Friction of the small motion, in N m s/rad."""
    delay: float
    """From the voltage or torque to the motion [s]."""
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
    """Position over torque at frequencies [Hz], with the other motors at rest."""


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
    data = _Data(omega, G, weight, measured.others[used])
    rigid, rigid_cost = _fit(_rigid, [np.array([np.log(inertia), 0, 0, delay]) for delay in _DELAYS], data)
    elastic, elastic_cost = _fit(_elastic, list(_initial_guesses(inertia, omega)), data)
    is_elastic = elastic_cost < _FEWER * rigid_cost and _is_resonance(elastic, omega)
    model, parameters = (_elastic, elastic) if is_elastic else (_rigid, rigid)
    antiresonance, resonance = _resonances(elastic) if is_elastic else (None, None)
    return AxisModel(
        inertia=float(np.exp(parameters[0])),
        viscous=float(np.exp(parameters[1])),
        # The torque of an older step makes the motion appear too early.
        delay=float(parameters[3]) + measured.torque_age,
        antiresonance=antiresonance,
        resonance=resonance,
        lines=len(omega),
        highest=float(omega[-1] / (2 * np.pi)),
        misfit=float(np.sqrt(np.mean(np.abs(model(parameters, omega, data.others) / G - 1) ** 2))),
        response=lambda frequency: model(parameters, 2 * np.pi * frequency, 0j * np.outer(frequency, data.others[0])),
    )


def _rigid(p: Floats, omega: Floats, others: Complex) -> Complex:
    return _delayed(p, omega, _rigid_torque(p, omega) + _coupling_torque(p, omega, others))


def _elastic(p: Floats, omega: Floats, others: Complex) -> Complex:
    antiresonance = np.exp(p[4])
    zeros = _second_order(omega / antiresonance, np.exp(p[6]))
    poles = _second_order(omega / (antiresonance * (1 + np.exp(p[5]))), np.exp(p[7]))
    return _delayed(p, omega, (_rigid_torque(p, omega) * poles + _coupling_torque(p, omega, others)) / zeros)


def _delayed(p: Floats, omega: Floats, torque: Complex) -> Complex:
    return np.exp(-1j * omega * p[3]) / torque


def _rigid_torque(p: Floats, omega: Floats) -> Complex:
    """Torque over position of a rigid axis, the other motors at rest."""
    inertia, viscous = np.exp(p[:2])
    return -inertia * omega**2 + 1j * viscous * omega + p[2]


def _coupling_torque(p: Floats, omega: Floats, others: Complex) -> Complex:
    """Torque of the coupling over the position of the joint; the last parameters are inertias relative to its own."""
    return -(omega**2) * (others @ _couplings(p, others)) * np.exp(p[0])


def _couplings(p: Floats, others: Complex) -> Floats:
    return p[len(p) - others.shape[1] :]


def _second_order(ratio: Floats, damping: float) -> Complex:
    return 1 - ratio**2 + 2j * damping * ratio


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


@dataclass(frozen=True, eq=False)
class _Data:
    """Lines that the models are fitted to."""

    omega: Floats
    """(n,) [rad/s]."""
    motion: Complex
    """(n,) position over torque."""
    weight: Floats
    """(n,) inverse of the relative standard deviation."""
    others: Complex
    """(n, dof - 1) position of the other joints over that of this one."""


def _fit(model: _Model, guesses: list[Floats], data: _Data) -> tuple[Floats, float]:
    """Least squares of the logarithmic deviations, from several initial guesses; parameters and cost."""

    def residuals(p: Floats) -> Floats:
        with np.errstate(all="ignore"):
            deviation = np.log(model(p, data.omega, data.others) / data.motion)
        expected = _couplings(p, data.others) / _COUPLING
        weighted = np.concatenate([deviation.real * data.weight, deviation.imag * data.weight, expected])
        return np.nan_to_num(weighted, nan=1e6, posinf=1e6, neginf=-1e6)

    uncoupled = np.zeros(data.others.shape[1])
    fits = [least_squares(residuals, np.append(guess, uncoupled), loss="soft_l1", max_nfev=150) for guess in guesses]
    best = min(fits, key=lambda result: float(result.cost))
    return np.asarray(best.x), float(best.cost)
