"""Find drifts and changes at one instant in the residual of a repeated motion."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ident.basics.statistics import TINY
from recordings.recording import Bools, Floats, Ints

SIGNIFICANT = 0.001
"""Significance level of a trend, and of a residual that repeats with the motion."""
_MIN_PHASES = 10
"""Minimum number of phases common to all cycles for a test of trends."""
_INSTANTS = 10
"""Number of instants within a cycle at which a change is searched."""
_ROUNDING = 1e-20
"""Relative to the mean square: less is a rounding error."""


@dataclass(frozen=True)
class Trend:
    """A pattern in the change of one joint's residual from cycle to cycle."""

    pattern: str
    """"linear"; "step after k": one level in the first k cycles, another in the following ones; or "step in cycle k":
    the level changes during that cycle."""
    p_value: float
    """Probability of such a change by chance, corrected for the number of patterns tested."""
    mean_square: float
    """Part of the residual's mean square, less the contribution of noise to the pattern."""

    @property
    def significant(self) -> bool:
        """Whether the trend is statistically significant."""
        return self.p_value < SIGNIFICANT


def clearest_trend(x: Floats, noise: float, freedom: float) -> tuple[Trend, float] | None:
    """Find the most significant pattern across the cycles of `x` (cycles, phases); None with fewer than three cycles.

    Noise has the same expected energy in every contrast between cycles. A pattern is a contrast whose amplitude
    depends on the phase. An F test compares its energy with the variance of the `noise`.

    freedom: effective degrees of freedom of the noise of one cycle.

    Returns the trend, and the variance between cycles without it.
    """
    from scipy.special import fdtrc

    x = x[np.isfinite(x).mean(axis=1) > 0.5]  # an incomplete cycle would leave few common phases
    x = x[:, np.isfinite(x).all(axis=0)]
    cycles, phases = x.shape
    if cycles < 3 or phases < _MIN_PHASES:
        return None
    total_energy = float(((x - x.mean(axis=0)) ** 2).sum() / phases)
    smallest = max(_ROUNDING * float((x**2).mean()), TINY)
    patterns, trends = list(_patterns(x, noise)), []
    for name, energy in patterns:
        others = max(total_energy - energy, 0.0) / (cycles - 2)
        level = min(noise, others)  # other changes are no noise, and a drift may be in the estimate of the noise
        chance = float(fdtrc(freedom, freedom * (cycles - 2), energy / max(level, smallest)))
        trends.append((Trend(name, min(1.0, len(patterns) * chance), (energy - level) / cycles), others))
    return min(trends, key=lambda pair: (pair[0].p_value, -pair[0].mean_square))


def _patterns(x: Floats, noise: float) -> Iterator[tuple[str, float]]:
    """Names and energies per phase of the patterns in `x` (cycles, phases) with `noise` of this variance."""
    cycles, phases = x.shape
    number = np.arange(cycles)
    yield "linear", float((_projection(number, x) ** 2).mean())
    none = np.full(phases, noise)  # a change before the first cycle or after the last one makes no difference
    steps = [none, *(_projection(number >= k, x) ** 2 for k in range(1, cycles)), none]
    for k in range(cycles):
        for instant in range(_INSTANTS):
            first = round(instant / _INSTANTS * phases)
            energy = float(steps[k + 1][:first].sum() + steps[k][first:].sum()) / phases
            yield f"step in cycle {k + 1}" if instant else f"step after {k}", energy


def _projection(profile: Bools | Ints, x: Floats) -> Floats:
    """(phases,) component of `x` (cycles, phases) along `profile` (cycles,), with zero sum and unit norm."""
    centred = profile - profile.mean()
    return centred @ x / np.linalg.norm(centred)
