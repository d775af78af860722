"""Cases on which the diagnosis was tuned. The list is always the same."""

from collections.abc import Iterator, Sequence
from itertools import combinations, product

import numpy as np

from benchmarks.hidden_effects.cases import (
    ADDED,
    BITS,
    COMMAND_ONLY,
    NEVER_TOGETHER,
    NOISE,
    PAIR_SIZES,
    HiddenCase,
    Kind,
    PlantName,
    RobotName,
    drawn_effects,
)
from drivers.simulated.effect import out_of_library as out_of_library_effects

ROBOTS: tuple[RobotName, ...] = ("default", "heavy", "light")
_RATES = {"simulated": (200, 250, 400, 500, 800, 900), "foreign": (200, 250, 400, 500, 800, 1000)}
"""Sampling rates [Hz]; the bus of the simulated rig does not allow 1 kHz."""


def tuned_cases(plant: PlantName) -> list[HiddenCase]:
    """All tuned cases of a plant, in a fixed random order: the first n are a representative sample.

    Those added later come last.
    """
    ordered = list(_simulated() if plant == "simulated" else _foreign())
    order = np.random.default_rng(0).permutation(len(ordered))
    return [*(ordered[i] for i in order), *_single_effects(plant, ADDED, 0.03, 2, "added")]


def _simulated() -> Iterator[HiddenCase]:
    for size, times in ((0.005, 1), (0.01, 2), (0.03, 2), (0.10, 1)):
        yield from _single_effects("simulated", drawn_effects(), size, times)
    yield from _nothing("simulated", 110)
    yield from _pairs("simulated", 75)
    for size, times in ((0.03, 3), (0.10, 2)):
        yield from _single_effects("simulated", out_of_library_effects(), size, times, "outside")


def _foreign() -> Iterator[HiddenCase]:
    from tests.foreign.out_of_library import KINDS

    for size, times in ((0.01, 2), (0.03, 2), (0.10, 1)):
        yield from _single_effects("foreign", drawn_effects(), size, times)
    yield from _nothing("foreign", 110)
    yield from _pairs("foreign", 75)
    yield from _single_effects("foreign", tuple(KINDS), 0.03, 3, "outside")


def _single_effects(
    plant: PlantName, effects: Sequence[str], size: float, times: int, kind: Kind = "single"
) -> Iterator[HiddenCase]:
    """Each effect, `times` times on each robot."""
    for effect in effects:
        for number in range(times * len(ROBOTS)):
            yield _case(plant, kind, (effect,), (size,), ROBOTS[number % len(ROBOTS)], number + 1)


def _pairs(plant: PlantName, count: int) -> Iterator[HiddenCase]:
    possible = [pair for pair in combinations(drawn_effects(), 2) if frozenset(pair) not in NEVER_TOGETHER]
    for number, index in enumerate(np.random.default_rng(1).permutation(len(possible))[:count]):
        first, second = possible[index]
        pair = (first, second) if number % 4 < 2 else (second, first)
        sizes = PAIR_SIZES[number % len(PAIR_SIZES)]
        yield _case(plant, "pair", pair, sizes, ROBOTS[number % len(ROBOTS)], number + 1)


def _nothing(plant: PlantName, count: int) -> Iterator[HiddenCase]:
    """Cases without hidden effects; half of them cover the whole range of encoder resolution and rate."""
    conditions = list(product(range(12, 21), _RATES[plant]))
    order = np.random.default_rng(4).permutation(len(conditions))
    for number in range(count):
        rng = np.random.default_rng([2, number])
        varied = number % 2 == 1
        bits, rate = conditions[order[number // 2 % len(order)]] if varied else (int(rng.choice(BITS)), 500)
        yield HiddenCase(
            plant,
            "nothing",
            (),
            (),
            ROBOTS[number % len(ROBOTS)],
            number + 1,
            volts=float(rng.choice(NOISE)),
            bits=bits,
            rate=float(rate),
            reports_command=bool(rng.random() < 0.5),
        )


def _case(
    plant: PlantName, kind: Kind, effects: tuple[str, ...], sizes: tuple[float, ...], robot: RobotName, number: int
) -> HiddenCase:
    rng = np.random.default_rng([3, *"".join(effects).encode(), number])
    return HiddenCase(
        plant,
        kind,
        effects,
        sizes,
        robot,
        number,
        volts=float(rng.choice(NOISE)),
        bits=int(rng.choice(BITS)),
        # Half of the other cases too, so that the kind of voltage does not reveal the effect.
        reports_command=bool(set(effects) & set(COMMAND_ONLY)) or bool(rng.random() < 0.5),
    )
