"""Cases of the formula benchmark: on the foreign plant, under the conditions of `benchmarks.hidden_effects`."""

from zlib import crc32

import numpy as np

from benchmarks.hidden_effects.cases import HiddenCase, Kind, Part, drawn_effects
from benchmarks.hidden_effects.drawn_cases import evenly, with_conditions
from tests.foreign.beyond_library import QUANTITIES

_SIZES = (0.03, 0.04, 0.05)
_COUNT = 120
"""Cases of each kind."""


def cases(kind: Kind, part: Part, digest: str = "") -> list[HiddenCase]:
    """Cases of one part with laws outside of the library, nothing, or a single effect of the library.

    The first n have all laws about equally often. digest: that of the commit, which determines the locked part.
    """
    digest = digest if part == "locked" else ""
    rng = np.random.default_rng(crc32(f"formulas {kind} {part} {digest}".encode()))
    names = evenly(rng, tuple(QUANTITIES) if kind == "outside" else drawn_effects(), _COUNT)
    hidden = [((), ())] * _COUNT if kind == "nothing" else [((name,), (float(rng.choice(_SIZES)),)) for name in names]
    return [
        with_conditions(HiddenCase("foreign", kind, effects, sizes, "any", number, part, digest))
        for number, (effects, sizes) in enumerate(hidden, start=1)
    ]
