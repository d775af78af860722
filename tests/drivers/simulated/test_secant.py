import math
from collections.abc import Callable

import pytest

from drivers.simulated.secant import solve


@pytest.mark.parametrize(
    "law",
    [
        lambda s: 0.3 * s,
        lambda s: 0.05 * math.sqrt(s),
        lambda s: 0.01 * s**12,
        lambda s: 0.02 * s + 1e-4,
        lambda s: 0.03 * s if s < 2 else math.inf,
        lambda s: 1e-6 if s < 0.9 else 0.2 * s,
    ],
    ids=["line", "root", "steep", "floor", "end", "step"],
)
@pytest.mark.parametrize("start", [0.1, 1.0, 5.0])
def test_strength_of_the_target_size_is_found(law: Callable[[float], float], start: float) -> None:
    trials = []

    def size(strength: float) -> float:
        trials.append(strength)
        return law(strength)

    target_size = law(1.1)
    solution = solve(size, target_size, start=start, largest=10.0)
    assert solution is not None
    strength, reached = solution
    assert reached == pytest.approx(target_size, rel=0.02)
    assert law(strength) == pytest.approx(reached)
    assert max(trials) <= 10.0


def test_extremes() -> None:
    """A straight line takes two trials; the largest strength where a size is out of reach; none if it is infinite."""
    trials: list[float] = []
    solve(lambda s: trials.append(s) or 0.3 * s, 0.9, start=1.0, largest=10.0)
    assert len(trials) == 2
    assert solve(lambda s: 0.01 * s, 1.0, start=1.0, largest=10.0) == pytest.approx((10.0, 0.1))
    assert solve(lambda s: math.inf, 1.0, start=1.0, largest=10.0) is None
