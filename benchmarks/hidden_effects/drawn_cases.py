"""Cases drawn for the foreign plant: robots of any size, with and without repetition, voltages and efforts."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from zlib import crc32

import numpy as np

from benchmarks.hidden_effects.cases import (
    ADDED,
    BITS,
    COMMAND_ONLY,
    NEVER_TOGETHER,
    NOISE,
    PAIR_SIZES,
    VOLTAGE_ONLY,
    HiddenCase,
    Kind,
    Part,
    drawn_effects,
)
from tests.foreign.out_of_library import KINDS

_SINGLES = 300
"""Single effects of each size."""
_OTHERS = 100
"""Cases with nothing hidden, pairs, and cases outside of the library."""
_ADDED = 60
"""Cases of the kind `added`."""
_SIZES = (0.03, 0.01)
_RATES = (100, 125, 200, 250, 400, 500, 800, 1000)
"""Sampling rates [Hz]."""
_COARSE = 10
"""Resolution of the coarse signals [bit]."""
_SHARE_OF_COARSE = 1 / 3


def drawn_cases(part: Part, digest: str = "") -> list[HiddenCase]:
    """All cases of a part, in a random order: the first n are a representative sample. Those added later come last.

    digest: that of the commit, which determines the cases of the locked part.
    """
    rng = np.random.default_rng(crc32(f"{part} {digest}".encode()))
    hidden = list(_hidden(rng))
    drawn = []
    for i in rng.permutation(len(hidden)).tolist():
        kind, effects, sizes = hidden[i]
        drawn.append(with_conditions(HiddenCase("foreign", kind, effects, sizes, "any", i + 1, part, digest)))
    for number, effect in enumerate(evenly(rng, ADDED, _ADDED), start=1):
        case = HiddenCase("foreign", "added", (effect,), (_SIZES[0],), "any", number, part, digest)
        drawn.append(with_conditions(case))
    return drawn


def _hidden(rng: np.random.Generator) -> Iterator[tuple[Kind, tuple[str, ...], tuple[float, ...]]]:
    """Kind, effects and sizes of each case."""
    for size in _SIZES:
        for effect in evenly(rng, drawn_effects(), _SINGLES):
            yield "single", (effect,), (size,)
    for _ in range(_OTHERS):
        yield "nothing", (), ()
    possible = [pair for pair in combinations(drawn_effects(), 2) if frozenset(pair) not in NEVER_TOGETHER]
    for number, index in enumerate(rng.permutation(len(possible))[:_OTHERS]):
        first, second = possible[index]
        pair = (first, second) if rng.random() < 0.5 else (second, first)
        yield "pair", pair, PAIR_SIZES[number % len(PAIR_SIZES)]
    for effect in evenly(rng, tuple(KINDS), _OTHERS):
        yield "outside", (effect,), (0.03,)


def evenly(rng: np.random.Generator, effects: Sequence[str], count: int) -> list[str]:
    """As many `effects` as `count`, each about equally often."""
    order = rng.permutation(len(effects))
    return [effects[order[number % len(effects)]] for number in range(count)]


def with_conditions(case: HiddenCase) -> HiddenCase:
    """The `case` with sensors and signals that are drawn from its seed."""
    rng = np.random.default_rng([6, case.seed])
    effort = bool(rng.random() < 0.5) and not set(case.effects) & set(VOLTAGE_ONLY)
    return replace(
        case,
        volts=float(rng.choice(NOISE)),
        bits=int(rng.choice(BITS)),
        rate=float(rng.choice(_RATES)),
        repeats=bool(rng.random() < 0.5),
        signal_bits=_COARSE if rng.random() < _SHARE_OF_COARSE else None,
        signal="effort" if effort else "voltage",
        # In half of the other cases too, so that the kind of voltage does not reveal the effect.
        reports_command=not effort and (bool(set(case.effects) & set(COMMAND_ONLY)) or bool(rng.random() < 0.5)),
    )
