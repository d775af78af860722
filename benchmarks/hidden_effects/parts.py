"""The parts of the benchmark, and their cases.

The diagnosis was tuned on the first. Criteria and thresholds are chosen on the second. The third decides nothing: its
cases are drawn from the digest of the commit, so that each commit has others.
"""

from typing import get_args

from benchmarks.hidden_effects.cases import HiddenCase, Part, PlantName

PARTS: tuple[Part, ...] = get_args(Part)


def cases(plant: PlantName, part: Part = "tuned", digest: str = "") -> list[HiddenCase]:
    """All cases of a part, in random order; digest: what the locked part is drawn from.

    The simulated rig has the tuned part only.
    """
    from benchmarks.hidden_effects.drawn_cases import drawn_cases
    from benchmarks.hidden_effects.tuned_cases import tuned_cases

    if part == "tuned":
        return tuned_cases(plant)
    if plant == "simulated":
        return []
    return drawn_cases(part, digest if part == "locked" else "")
